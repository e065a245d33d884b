// Files that nobody else may read: keys and tokens.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"

namespace gnomon::daemon {

// Error: `key` (of the configuration), the file, and what would help.
Result<void> check_private(const std::string& key, const std::filesystem::path& file);

}  // namespace gnomon::daemon
