// Reading files that the configuration names, with errors that say why in the system's words.
#pragma once

#include <filesystem>
#include <string>

#include "common/result.h"

namespace gnomon::daemon {

// The file's bytes. Error: "PATH: No such file or directory", "PATH: Is a directory", "PATH: the file is empty".
Result<std::string> read_file(const std::filesystem::path& file);

// As read_file(), of a file that is read elsewhere: it is opened and a byte is read.
Result<void> check_readable(const std::filesystem::path& file);

// Error if this process could not make files in `folder`, which is made, with those above it, if it does not exist.
Result<void> check_writable_folder(const std::filesystem::path& folder);

}  // namespace gnomon::daemon
