// What a worker process is given to do, and what it may use. It stands in the descriptor kExchange, a file in memory, in
// which the worker leaves the outcome in its place.
#pragma once

#include <cstdint>
#include <cstdio>
#include <span>
#include <variant>

#include "common/log.h"
#include "common/result.h"
#include "gpu/builds/packed_builds.h"
#include "scenes/packed/packed_scene.h"

namespace gnomon::daemon {

inline constexpr int kExchange = 3;
inline constexpr int kProgress = 4;  // a pipe into which the worker writes Progress, and nothing else

struct Progress {
  uint64_t light = 0;  // 0 of a scene that is read
  double share = 0;    // of that light's work, or of the reading, 0 to 1
};

struct WorkerTask {
  uint64_t max_memory_bytes = 0;  // of address space
  uint32_t max_cpu_seconds = 0;   // of all its threads together
  int32_t niceness = 0;           // added to that of the daemon, in the units of nice(2)
  log::Level log_level = log::Level::info;
  log::Format log_format = log::Format::key_value;
  std::variant<scenes::LoadTask, gpu::BuildTask> work;
};

// Error: the file cannot be written.
Result<void> write_task(const WorkerTask& task, std::FILE* file);
Result<WorkerTask> read_task(std::span<const std::byte> bytes);

}  // namespace gnomon::daemon
