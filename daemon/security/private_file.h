// A check for files that nobody else may read: keys and tokens.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"

namespace gnomon::daemon {

// Error if others may read the file; it names `key` (of the configuration), the file and the remedy.
Result<void> check_private(const std::string& key, const std::filesystem::path& file);

}  // namespace gnomon::daemon
