// Writes files that others must never see half written.
#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>

#include "common/result.h"

namespace gnomon::ctl {

// The file appears under its name only when it is complete, and replaces one that is there. It belongs to the group that
// its folder gives it.
Result<void> write_file(const std::filesystem::path& file, const std::string& text, mode_t mode);

// What stands in it; empty if it cannot be read.
std::string read_file(const std::filesystem::path& file);

}  // namespace gnomon::ctl
