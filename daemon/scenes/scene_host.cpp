#include "daemon/scenes/scene_host.h"

namespace gnomon::daemon {
namespace {

// One tenant may have half of them at work (load_queue.h).
constexpr uint32_t kLoaders = 4;

const Error kNobodyWaits{"nobody waits for it any more"};

}  // namespace

SceneHost::SceneHost(const SceneCatalog& catalog, DevicePool& devices, Metrics& metrics, scenes::SceneReader read)
    : registry_(catalog.sources(), {}, std::move(read)), devices_(devices), metrics_(metrics), requests_(kLoaders) {
  for (uint32_t i = 0; i < kLoaders; ++i) loaders_.emplace_back([this] { serve_requests(); });
}

SceneHost::~SceneHost() {
  stop_reading();
  for (std::thread& loader : loaders_) loader.join();
}

void SceneHost::stop_reading() {
  {
    std::lock_guard lock(mutex_);
    ending_ = true;
    for (auto& [name, reading] : reading_) reading.stop.request_stop();
  }
  changed_.notify_all();
}

void SceneHost::serve_requests() {
  while (auto request = next_request()) {
    std::unique_lock lock(mutex_);
    const auto [reading, first] = reading_.try_emplace(request->name);
    reading->second.waiting.push_back(*request);
    if (first) {
      const std::stop_token stop = reading->second.stop.get_token();
      lock.unlock();
      const auto loaded = read(*request, stop);
      lock.lock();
      const std::vector<Request> waiting = std::move(reading->second.waiting);
      reading_.erase(reading);
      // Who asked after the reader had been stopped has it read anew.
      const bool again = !loaded && stop.stop_requested() && !ending_;
      if (again) {
        for (const Request& other : waiting) requests_.push(other.asker, other);
      }
      lock.unlock();
      for (const Request& other : waiting) {
        if (!again) bring(other, loaded);
      }
      lock.lock();
    }
    requests_.done(request->asker);
    lock.unlock();
    changed_.notify_all();
  }
}

// Waits for a request that may be read now. nullopt when the host ends.
std::optional<SceneHost::Request> SceneHost::next_request() {
  std::unique_lock lock(mutex_);
  std::optional<Request> next;
  changed_.wait(lock, [&] { return ending_ || (next = requests_.start()); });
  return ending_ ? std::nullopt : next;
}

Result<scenes::LoadedScene> SceneHost::read(const Request& request, std::stop_token stop) {
  if (!request.asker) registry_.retry(request.name);
  auto loaded = registry_.get(request.name, std::move(stop));
  if (loaded && loaded->scene->lights.empty()) return Error{"it has no lights: there is nothing to trace"};
  return loaded;
}

FetchId SceneHost::fetch(const std::string& name, Ready ready, SceneAsker asker) {
  FetchId id;
  {
    std::unique_lock lock(mutex_);
    id.value = ++last_fetch_;
    if (const auto found = resident_.find(name); found != resident_.end()) {
      SceneForUse scene{found->second.scene.loaded, SceneUse(found->second.uses)};
      lock.unlock();
      ready(std::move(scene));
      return id;
    }
    requests_.push(asker, {id, name, std::move(ready), asker});
  }
  changed_.notify_all();
  return id;
}

void SceneHost::give_up(FetchId fetch) {
  Ready ready;
  const auto take = [&](Request& request) {
    if (request.id != fetch) return false;
    ready = std::move(request.ready);
    return true;
  };
  {
    std::lock_guard lock(mutex_);
    requests_.drop(take);
    for (auto& [name, reading] : reading_) {
      const bool found = std::erase_if(reading.waiting, take) > 0;
      if (found && reading.waiting.empty()) reading.stop.request_stop();
    }
  }
  if (ready) ready(kNobodyWaits);
}

void SceneHost::bring(Request request, const Result<scenes::LoadedScene>& loaded) {
  if (!loaded) return request.ready(loaded.error());
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
