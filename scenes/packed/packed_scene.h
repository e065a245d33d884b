// A scene, and the task of loading one, as bytes that another process of this build reads. See archive.h.
#pragma once

#include <cstdio>
#include <filesystem>
#include <span>
#include <vector>

#include "common/log.h"
#include "common/result.h"
#include "scenes/loader.h"
#include "scenes/scene.h"

namespace gnomon::scenes {

// What a worker process is given to do.
struct LoadTask {
  std::filesystem::path file;
  std::vector<NodeMotion> motions;
  LoadLimits limits;
  uint64_t max_memory_bytes = 0;  // of the worker's address space
  uint32_t max_cpu_seconds = 0;
  log::Level log_level = log::Level::info;
  log::Format log_format = log::Format::key_value;
};

// Error: the file cannot be written.
Result<void> write_task(const LoadTask& task, std::FILE* file);
Result<LoadTask> read_task(std::span<const std::byte> bytes);

// A scene or the reason why there is none. Error: the file cannot be written.
Result<void> write_outcome(const Result<ScenePtr>& scene, std::FILE* file);

// The scene, or the reason that was written. The bytes are untrusted: a scene that breaks what scenes/scene.h promises
// or that exceeds the limits is an error. Its content hash is taken as it is written.
Result<ScenePtr> read_outcome(std::span<const std::byte> bytes, const LoadLimits& limits);

}  // namespace gnomon::scenes
