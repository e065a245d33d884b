#include "daemon/scene_host.h"

#include <future>

namespace gnomon::daemon {

SceneHost::SceneHost(const SceneCatalog& catalog, RenderInbox& inbox, Metrics& metrics)
    : registry_(catalog.sources(), {}), inbox_(inbox), metrics_(metrics), loader_([this] {
        std::vector<Request> batch;
        for (requests_.take(batch); !batch.empty(); requests_.take(batch)) {
          for (Request& request : batch) {
            if (requests_.closed()) break;
            load(std::move(request));
          }
        }
      }) {}

SceneHost::~SceneHost() {
  requests_.close();
  loader_.join();
}

void SceneHost::fetch(const std::string& name, Ready ready) {
  {
    std::unique_lock lock(mutex_);
    if (const auto found = resident_.find(name); found != resident_.end()) {
      const scenes::LoadedScene scene = found->second.loaded;
      lock.unlock();
      return ready(scene);
    }
  }
  requests_.push({name, std::move(ready)});
}

void SceneHost::load(Request request) {
  auto loaded = registry_.get(request.name);
  if (!loaded) return request.ready(loaded.error());
  if (loaded->scene->lights.empty()) return request.ready(Error{"it has no lights: there is nothing to trace"});
  SceneArrived arrived;
  arrived.scene = *loaded;
  arrived.name = request.name;
  arrived.resident = [this, scene = *loaded, request](Result<gpu::SceneFootprint> on_device) {
    if (!on_device) return request.ready(on_device.error());
    keep(request.name, {scene, *on_device, {request.name, 0, scene.scene->lights}});
    request.ready(scene);
  };
  if (!inbox_.push(std::move(arrived))) request.ready(Error{"the server is stopping"});
}

void SceneHost::keep(const std::string& name, const HostedScene& scene) {
  log::info("scene resident", {{"scene", name},
                               {"device_bytes", scene.on_device.memory_bytes},
                               {"tracer_bytes", scene.on_device.tracer_memory_bytes},
                               {"build_seconds", scene.on_device.tracer_build_seconds},
                               {"from_cache", scene.on_device.tracer_from_cache}});
  std::lock_guard lock(mutex_);
  resident_.emplace(name, scene);
}

Result<void> SceneHost::fetch_now(const std::string& name) {
  std::promise<Result<void>> answered;
  fetch(name, [&](Result<scenes::LoadedScene> scene) {
    answered.set_value(scene ? Result<void>() : Result<void>(scene.error()));
  });
  return answered.get_future().get();
}

void SceneHost::keep_lights(const LightsNews& news) {
  std::lock_guard lock(mutex_);
  if (const auto found = resident_.find(news.scene); found != resident_.end()) found->second.lights = news;
}

LightsNews SceneHost::lights_of(const std::string& name) const {
  std::lock_guard lock(mutex_);
  const auto found = resident_.find(name);
  return found == resident_.end() ? LightsNews{} : found->second.lights;
}

std::map<std::string, HostedScene> SceneHost::resident() const {
  std::lock_guard lock(mutex_);
  return resident_;
}

}  // namespace gnomon::daemon
