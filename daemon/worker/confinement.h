// What a process that reads untrusted files gives up before it opens one: memory, time, the network, every file but
// those of one folder, and every system call that reading and computing do not need.
#pragma once

#include <cstdint>
#include <filesystem>

#include "common/result.h"

namespace gnomon::daemon {

struct Confinement {
  std::filesystem::path folder;   // what may be read: its files and those of its subfolders; if empty, no file
  uint64_t max_memory_bytes = 0;  // of address space; 0: unlimited
  uint32_t max_cpu_seconds = 0;   // of processor time; 0: unlimited
  uint64_t max_file_bytes = 0;    // of a file that is written; 0: unlimited
};

// Confines the calling process, for good. Precondition: it has one thread. Landlock holds the folder where the kernel
// has it (5.13), and seccomp the calls; the log says where a kernel lacks one of them. Limits hold everywhere. A
// forbidden call ends the process with SIGSYS, memory beyond its limit fails to be allocated, and processor time beyond
// it ends in SIGXCPU. Error: the kernel refused a part of it, named in the message.
Result<void> confine(const Confinement& to);

// The limits alone, for builds with sanitizers: their runtimes read /proc and call what the filter refuses.
Result<void> limit_resources(const Confinement& to);

}  // namespace gnomon::daemon
