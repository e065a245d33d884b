// How much memory this process may use.
#pragma once

#include <cstdint>
#include <filesystem>

namespace gnomon::daemon {

// Bytes: the machine's memory, or less where a control group (version 2), a container's included, allows less. `root`:
// of the file system; another one in tests.
uint64_t usable_memory_bytes(const std::filesystem::path& root = "/");

}  // namespace gnomon::daemon
