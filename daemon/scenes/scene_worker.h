// What the daemon has done by gnomon-scene-worker, so that no file can take its memory, time or life: scenes are read,
// and what traces them is built, each in a process of its own.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stop_token>

#include "common/log.h"
#include "common/result.h"
#include "daemon/config/config.h"
#include "gpu/builds/structure_builds.h"
#include "scenes/loader.h"
#include "scenes/registry.h"

namespace gnomon::daemon {

// How workers log, to the daemon's standard error. A reload changes it; any thread.
struct WorkerLog {
  std::atomic<log::Level> level{log::Level::warning};
  std::atomic<log::Format> format{log::Format::key_value};
};

struct SceneWorkerOptions {
  std::filesystem::path program;                  // gnomon-scene-worker
  uint64_t max_memory_bytes = uint64_t{4} << 30;  // of address space
  std::chrono::seconds max_time{120};         // of processor time, and of twice as much real time, to read a scene
  std::chrono::seconds max_build_time{1800};  // the same to build what traces it
  scenes::Colours colours = scenes::Colours::none;  // encoded: browsers get their scenes from this daemon
  std::shared_ptr<WorkerLog> log = std::make_shared<WorkerLog>();  // read when a worker is started
};

SceneWorkerOptions worker_options(const Config& config, std::filesystem::path program);

// Blocks until the scene is there, or the worker has failed, exceeded a limit, or been stopped through `watch`. Any
// thread. The error says why there is no scene: the loader's own reason, or which limit the worker met.
Result<scenes::ScenePtr> load_in_worker(const SceneWorkerOptions& options, const scenes::SceneSource& source,
                                        const scenes::LoadLimits& limits, const scenes::Watch& watch = {});

// load_in_worker with these options.
scenes::SceneReader reader_in_worker(const SceneWorkerOptions& options);

// Builds in workers. Any thread, several at a time.
gpu::StructureBuildsPtr builds_in_worker(const SceneWorkerOptions& options);

}  // namespace gnomon::daemon
