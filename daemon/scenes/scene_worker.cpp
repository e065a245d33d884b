#include "daemon/scenes/scene_worker.h"

#include "common/within_memory.h"
#include "daemon/scenes/worker_process.h"

namespace gnomon::daemon {
namespace {

// Frames have precedence. A build of light buffers gets more than a reader, because it makes frames several times
// cheaper when it is done.
constexpr int32_t kNicenessOfReaders = 10;
constexpr int32_t kNicenessOfLightBuffers = 5;

WorkerTask task_of(const SceneWorkerOptions& options, std::chrono::seconds time) {
  WorkerTask task;
  task.max_memory_bytes = options.max_memory_bytes;
  task.max_cpu_seconds = static_cast<uint32_t>(time.count());
  task.niceness = kNicenessOfReaders;
  task.log_level = options.log->level;
  task.log_format = options.log->format;
  return task;
}

class BuildsInWorker : public gpu::StructureBuilds {
 public:
  explicit BuildsInWorker(SceneWorkerOptions options) : options_(std::move(options)) {}

  Result<gpu::Bvh> bvh(const scenes::WorldMesh& mesh) const override {
    gpu::BuildTask build;
    build.mesh = &mesh;
    WorkerTask task = task_of(options_, options_.max_build_time);
    task.work = build;
    return answer<gpu::Bvh>(task, {.time = 2 * options_.max_build_time},
                            [&](std::span<const std::byte> bytes) { return gpu::read_bvh(bytes, mesh); });
  }

  Result<gpu::light_buffer::LightBuffer> light_buffer(
      const scenes::WorldMesh& mesh, const scenes::Bounds& bounds, std::span<const gpu::exact::TracedLight> lights,
      const gpu::light_buffer::BuildSettings& settings) const override {
    gpu::BuildTask build;
    build.kind = gpu::BuildTask::Kind::light_buffer;
    build.mesh = &mesh;
    build.bounds = bounds;
    build.lights.assign(lights.begin(), lights.end());
    build.detail = settings.detail;
    build.budget_bytes = settings.budget_bytes;
    WorkerTask task = task_of(options_, options_.max_build_time);
    task.niceness = kNicenessOfLightBuffers;
    task.work = build;
    const Patience patience{
        .time = 2 * options_.max_build_time, .stop = settings.stop, .on_progress = settings.progress};
    return answer<gpu::light_buffer::LightBuffer>(task, patience, [&](std::span<const std::byte> bytes) {
      return gpu::read_light_buffer(bytes, mesh, lights.size());
    });
  }

 private:
  template <class Built, class Read>
  Result<Built> answer(const WorkerTask& task, const Patience& patience, Read read) const {
    const auto outcome = run_worker(options_.program, task, patience);
    if (!outcome) return outcome.error();
    return within_memory([&] { return read(outcome->bytes()); });
  }

  const SceneWorkerOptions options_;
};

}  // namespace

SceneWorkerOptions worker_options(const Config& config, std::filesystem::path program) {
  SceneWorkerOptions options{.program = std::move(program),
                             .max_memory_bytes = uint64_t{config.scenes.worker_memory_mb} << 20,
                             .max_time = config.scenes.worker_time,
                             .max_build_time = config.scenes.build_time,
                             .colours = config.web.listen ? scenes::Colours::encoded : scenes::Colours::none};
  options.log->level = config.log.level;
  options.log->format = config.log.format;
  return options;
}

Result<scenes::ScenePtr> load_in_worker(const SceneWorkerOptions& options, const scenes::SceneSource& source,
                                        const scenes::LoadLimits& limits, const scenes::Watch& watch) {
  WorkerTask task = task_of(options, options.max_time);
  task.work = scenes::LoadTask{source.file, source.motions, limits, options.colours};
  Patience patience{.time = 2 * options.max_time, .stop = watch.stop};
  if (watch.on_share) patience.on_progress = [&watch](size_t, double share) { watch.on_share(share); };
  const auto outcome = run_worker(options.program, task, patience);
  if (!outcome) return outcome.error();
  return within_memory([&] { return scenes::read_outcome(outcome->bytes(), limits); });
}

scenes::SceneReader reader_in_worker(const SceneWorkerOptions& options) {
  return [options](const scenes::SceneSource& source, const scenes::LoadLimits& limits,
                   const scenes::Watch& watch) { return load_in_worker(options, source, limits, watch); };
}

gpu::StructureBuildsPtr builds_in_worker(const SceneWorkerOptions& options) {
  return std::make_shared<const BuildsInWorker>(options);
}

}  // namespace gnomon::daemon
