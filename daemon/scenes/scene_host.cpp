#include "daemon/scenes/scene_host.h"

namespace gnomon::daemon {
namespace {

// A scene that is slow to read delays nobody as long as there are fewer of them than loaders.
constexpr int kLoaders = 4;

}  // namespace

SceneHost::SceneHost(const SceneCatalog& catalog, DevicePool& devices, Metrics& metrics, scenes::SceneReader read)
    : registry_(catalog.sources(), {}, std::move(read)), devices_(devices), metrics_(metrics) {
  for (int i = 0; i < kLoaders; ++i) loaders_.emplace_back([this] { serve_requests(); });
}

SceneHost::~SceneHost() {
  {
    std::lock_guard lock(mutex_);
    ending_ = true;
  }
  changed_.notify_all();
  for (std::thread& loader : loaders_) loader.join();
}

void SceneHost::serve_requests() {
  std::unique_lock lock(mutex_);
  while (true) {
    changed_.wait(lock, [this] { return ending_ || !requests_.empty(); });
    if (ending_) return;
    Request request = requests_.pop();
    const std::string name = request.name;
    const auto [others, first] = reading_.try_emplace(name);
    if (!first) {
      others->second.push_back(std::move(request));  // one loader is enough for a scene
      continue;
    }
    lock.unlock();
    load(std::move(request));
    lock.lock();
    std::vector<Request> waiting = std::move(others->second);
    reading_.erase(others);
    lock.unlock();
    for (Request& other : waiting) load(std::move(other));  // the registry has the scene, or remembers the refusal
    lock.lock();
  }
}

void SceneHost::fetch(const std::string& name, Ready ready, SceneAsker asker) {
  {
    std::unique_lock lock(mutex_);
    if (const auto found = resident_.find(name); found != resident_.end()) {
      SceneForUse scene{found->second.scene.loaded, SceneUse(found->second.uses)};
      lock.unlock();
      return ready(std::move(scene));
    }
    requests_.push(asker, {name, std::move(ready), asker});
  }
  changed_.notify_one();
}

void SceneHost::load(Request request) {
  if (!request.asker) registry_.retry(request.name);
  auto loaded = registry_.get(request.name);
  if (!loaded) return request.ready(loaded.error());
  if (loaded->scene->lights.empty()) return request.ready(Error{"it has no lights: there is nothing to trace"});
  SceneLoaded arrived;
  arrived.scene = *loaded;
  arrived.name = request.name;
  arrived.resident = [this, scene = *loaded, request](Result<gpu::SceneFootprint> on_device) {
    if (!on_device) return refuse(request, on_device.error());
    HostedScene hosted;
    hosted.loaded = scene;
    hosted.on_device = *on_device;
    hosted.lights = {request.name, 0, scene.scene->lights};
    request.ready(keep(request.name, hosted));
  };
  {
    std::lock_guard lock(mutex_);
    on_the_way_.insert(request.name);
  }
  devices_.bring(arrived);
}

void SceneHost::refuse(const Request& request, const Error& why) {
  {
    std::lock_guard lock(mutex_);
    on_the_way_.erase(on_the_way_.find(request.name));
  }
  request.ready(why);
}

SceneForUse SceneHost::keep(const std::string& name, HostedScene scene) {
  log::info("scene resident", {{"scene", name},
                               {"device_bytes", scene.on_device.memory_bytes},
                               {"tracer_bytes", scene.on_device.tracer_memory_bytes},
                               {"build_seconds", scene.on_device.tracer_build_seconds},
                               {"from_cache", scene.on_device.tracer_from_cache}});
  std::lock_guard lock(mutex_);
  on_the_way_.erase(on_the_way_.find(name));
  const Resident& kept = resident_.try_emplace(name, Resident{std::move(scene)}).first->second;
  return {kept.scene.loaded, SceneUse(kept.uses)};
}

// Under one lock, a caller that got the scene before counts as a user here, and a caller that asks later has it brought
// again: the devices receive the removal before the new arrival.
Result<void> SceneHost::unload(const std::string& name) {
  {
    std::lock_guard lock(mutex_);
    const auto found = resident_.find(name);
    if (found == resident_.end()) return Error{"no such scene is resident"};
    const uint32_t users = *found->second.uses;
    if (users > 0) return Error{"sessions use it: " + std::to_string(users)};
    if (on_the_way_.contains(name)) return Error{"it is being loaded"};
    devices_.take_away(found->second.scene.loaded.id);
    resident_.erase(found);
  }
  registry_.forget(name);
  metrics_.scenes().unloaded(name);
  log::info("scene unloaded", {{"scene", name}});
  return {};
}

std::future<Result<void>> SceneHost::fetch_later(const std::string& name) {
  const auto answered = std::make_shared<std::promise<Result<void>>>();
  fetch(name, [answered](Result<SceneForUse> scene) {
    answered->set_value(scene ? Result<void>() : Result<void>(scene.error()));
  });
  return answered->get_future();
}

void SceneHost::keep_lights(const LightsUpdate& update) {
  std::lock_guard lock(mutex_);
  const auto found = resident_.find(update.scene);
  // The slower ones of several devices announce older versions.
  if (found == resident_.end()) return;
  LightsUpdate& known = found->second.scene.lights;
  if (update.version >= known.version) known = update;
}

LightsUpdate SceneHost::lights_of(const std::string& name) const {
  std::lock_guard lock(mutex_);
  const auto found = resident_.find(name);
  return found == resident_.end() ? LightsUpdate{} : found->second.scene.lights;
}

std::map<std::string, HostedScene> SceneHost::resident() const {
  std::lock_guard lock(mutex_);
  std::map<std::string, HostedScene> scenes;
  for (const auto& [name, resident] : resident_) {
    HostedScene& scene = scenes.emplace(name, resident.scene).first->second;
    scene.users = *resident.uses;
  }
  return scenes;
}

}  // namespace gnomon::daemon
