#include "daemon/scenes/scene_host.h"

#include <algorithm>
#include <atomic>
#include <limits>

#include "common/within_memory.h"
#include "daemon/config/scene_memory.h"
#include "daemon/scenes/expected_memory.h"

namespace gnomon::daemon {
namespace {

// Of one tenant half of them are under way at most, from the file to the devices (common/fair_queue.h); the operator's may
// be all.
constexpr uint32_t kLoaders = 4;

gpu::SceneOwner owner_for(SceneAsker asker) { return gpu::SceneOwner(asker ? asker->value + 1 : 0); }

const Error kNobodyWaits{"nobody waits for it any more"};
const Error kNoMemory{"no memory"};  // so short that copies allocate nothing

}  // namespace

SceneMemoryLimits scene_memory_limits(const Config& config) {
  SceneMemoryLimits limits;
  limits.all_bytes = scene_memory_bytes(config);
  for (const TenantConfig& tenant : config.tenants) {
    limits.of_tenant.push_back(uint64_t{tenant.max_scene_memory_mb} << 20);
  }
  return limits;
}

SceneHost::SceneHost(const SceneCatalog& catalog, DevicePool& devices, SceneLights& lights, Metrics& metrics,
                     scenes::SceneReader read, SceneMemory memory)
    : registry_(catalog.sources(), {}, std::move(read)),
      light_buffer_bytes_(memory.light_buffer_bytes),
      devices_(devices),
      lights_(lights),
      metrics_(metrics),
      requests_(kLoaders, SceneAsker{}),
      in_hand_(kLoaders) {
  alive_->host = this;
  account_.set_limits(std::move(memory.limits));
  for (uint32_t i = 0; i < kLoaders; ++i) loaders_.emplace_back([this] { serve_requests(); });
}

SceneHost::~SceneHost() {
  stop();
  std::lock_guard lock(alive_->mutex);
  alive_->host = nullptr;
}

void SceneHost::stop() {
  stop_reading();
  for (std::thread& loader : loaders_) loader.join();
  loaders_.clear();
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
    PlacePtr place;
    until_memory_suffices([&] { place = std::make_shared<Place>(alive_, request->asker); });
    if (!done_or_dropped("a request for a scene", [&] { serve(*request, place); })) request->refuse(kNoMemory);
  }
}

void SceneHost::Place::give_back() {
  if (given_back_.exchange(true)) return;
  std::lock_guard alive(alive_->mutex);
  SceneHost* const host = alive_->host;
  if (!host) return;
  {
    std::lock_guard lock(host->mutex_);
    host->requests_.done(asker_);
  }
  host->changed_.notify_all();
}

// Reads the scene, or waits with the request for whoever reads it already.
void SceneHost::serve(const Request& request, const PlacePtr& place) {
  std::unique_lock lock(mutex_);
  if (in_hand_.put_down(request.id)) {
    lock.unlock();
    return request.refuse(kNobodyWaits);
  }
  Reading own{{request}, {}, 0};
  const std::stop_token stop = own.stop.get_token();
  if (const auto [other, first] = reading_.try_emplace(request.name, std::move(own)); !first)
    return other->second.waiting.push_back(request);
  lock.unlock();
  const auto loaded = within_memory([&] { return read(request, stop); });
  lock.lock();
  const auto reading = reading_.extract(request.name);
  // What is on its way already takes no further place.
  const PlacePtr kept = on_the_way_.contains(request.name) ? nullptr : place;
  // Who asked after the reader had been stopped has it read anew.
  const bool again = !loaded && stop.stop_requested() && !ending_;
  if (loaded) {  // at once, so that it is under way until it is resident
    for (const Request& waiting : reading.mapped().waiting)
      until_memory_suffices([&] { on_the_way_.insert(waiting.name); });
  }
  if (again) {  // at once, so that who gives up meanwhile is found
    for (const Request& waiting : reading.mapped().waiting)
      until_memory_suffices([&] { requests_.push(waiting.asker, waiting); });
    return lock.unlock();
  }
  lock.unlock();
  for (const Request& waiting : reading.mapped().waiting) {
    if (!done_or_dropped("an answer about a scene", [&] { bring(waiting, loaded, kept); }))
      waiting.refuse(kNoMemory);
  }
}

// After another answer too, which the callback allows.
void SceneHost::Request::refuse(const Error& why) const {
  done_or_dropped("a refusal of a scene", [&] { ready(why); });
}

// Waits for a request that may be read now. nullopt when the host ends.
std::optional<SceneHost::Request> SceneHost::next_request() {
  std::unique_lock lock(mutex_);
  std::optional<Request> next;
  changed_.wait(lock, [&] { return ending_ || (next = requests_.start()); });
  if (ending_) return std::nullopt;
  in_hand_.take(next->id);
  return next;
}

Result<scenes::LoadedScene> SceneHost::read(const Request& request, const std::stop_token& stop) {
  if (!request.asker) registry_.retry(request.name);
  uint64_t most = 0;
  {
    std::lock_guard lock(mutex_);
    most = account_.largest(request.asker, [this](const std::string& name) { return is_free(name); });
  }
  if (most == std::numeric_limits<uint64_t>::max()) most = 0;  // no limit
  const auto on_share = [&](double share) {
    std::lock_guard lock(mutex_);
    double& known = reading_.at(request.name).share;
    known = std::max(known, share);
  };
  const scenes::Watch watch{stop, on_share};
  auto loaded = within_memory([&] { return registry_.get(request.name, watch, most); });
  if (!loaded || !loaded->scene->lights.empty()) return loaded;
  registry_.refuse(request.name, Error{kNoLights});
  return Error{kNoLights};
}

FetchId SceneHost::fetch(const std::string& name, Ready ready, SceneAsker asker) {
  FetchId id;
  {
    std::unique_lock lock(mutex_);
    id.value = ++last_fetch_;
    if (const auto found = resident_.find(name); found != resident_.end()) {
      SceneForUse scene{found->second.scene.loaded, SceneUse(found->second.uses), found->second.pack};
      account_.used(name);
      lock.unlock();
      ready(std::move(scene));
      return id;
    }
    Ready answer = counted(name, std::move(ready));
    requests_.push(asker, {id, name, std::move(answer), asker});
  }
  changed_.notify_all();
  return id;
}

// `ready`, after whose call the scene is under way for one request less.
SceneHost::Ready SceneHost::counted(const std::string& name, Ready ready) {
  UnderWay& counted = under_way_.try_emplace(name, UnderWay{0, Clock::now()}).first->second;
  ++counted.requests;
  const auto answered = std::make_shared<std::atomic<bool>>(false);
  return [this, name, ready = std::move(ready), answered](Result<SceneForUse> scene) {
    if (!answered->exchange(true)) {
      std::lock_guard lock(mutex_);
      const auto found = under_way_.find(name);
      if (--found->second.requests == 0) under_way_.erase(found);
    }
    ready(std::move(scene));
  };
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
    in_hand_.give_up(fetch);
  }
  if (ready) ready(kNobodyWaits);
}

void SceneHost::bring(Request request, const Result<scenes::LoadedScene>& loaded, const PlacePtr& place) {
  if (!loaded) return request.ready(loaded.error());
  if (auto room = within_memory([&] { return make_room(request, *loaded); }); !room) {
    {
      std::lock_guard lock(mutex_);
      on_the_way_.erase(on_the_way_.find(request.name));
    }
    return request.ready(room.error());
  }
  const auto asked = within_memory([&]() -> Result<void> {
    SceneLoaded arrived;
    arrived.scene = *loaded;
    arrived.name = request.name;
    arrived.owner = owner_for(request.asker);
    arrived.resident = [this, scene = *loaded, request, place](Result<gpu::SceneFootprint> on_device) {
      if (place) place->give_back();
      arrive(request, scene, on_device);
    };
    lights_.bring(arrived);
    return {};
  });
  if (asked) return;
  if (place) place->give_back();
  arrive(request, *loaded, asked.error());
}

// Enters the scene into the account, and takes away those that leave for it. Error: there is no room.
Result<void> SceneHost::make_room(const Request& request, const scenes::LoadedScene& loaded) {
  const uint64_t bytes = expected_memory(*loaded.scene, light_buffer_bytes_, devices_.report());
  std::lock_guard lock(mutex_);
  if (account_.bytes_of(request.name) == 0) {
    const auto leaving =
        account_.make_room(request.asker, bytes, [this](const std::string& n) { return is_free(n); });
    if (!leaving) {
      registry_.forget(request.name);
      return leaving.error();
    }
    for (const std::string& name : *leaving) {
      log::info("scene leaves for another one", {{"scene", name}, {"for", request.name}});
      take_away(name);
    }
    account_.add(request.name, request.asker, bytes);
  }
  return {};
}

bool SceneHost::is_free(const std::string& name) const {
  const auto found = resident_.find(name);
  return found != resident_.end() && *found->second.uses == 0 && !on_the_way_.contains(name);
}

// Under one lock, a caller that got the scene before counts as a user, and a caller that asks later has it brought
// again: the devices receive the removal before the new arrival.
void SceneHost::take_away(const std::string& name) {
  const auto found = resident_.find(name);
  devices_.take_away(found->second.scene.loaded.id);
  resident_.erase(found);
  account_.remove(name);
  registry_.forget(name);
  metrics_.scenes().unloaded(name);
}

// The scene is on the devices, or none could take it.
void SceneHost::arrive(const Request& request, const scenes::LoadedScene& scene,
                       const Result<gpu::SceneFootprint>& on_device) {
  const std::string& name = request.name;
  std::unique_lock lock(mutex_);
  on_the_way_.erase(on_the_way_.find(name));
  const bool last = !on_the_way_.contains(name);
  if (!on_device) {
    if (last) early_lights_.erase(name);
    if (last && !resident_.contains(name)) {
      account_.remove(name);
      devices_.take_away(scene.id);  // from those that could take it
      registry_.forget(name);
    }
    lock.unlock();
    return request.ready(on_device.error());
  }
  HostedScene hosted;
  hosted.loaded = scene;
  hosted.on_device = *on_device;
  const auto early = early_lights_.find(name);
  hosted.lights = early != early_lights_.end() ? early->second : LightsUpdate{name, 0, scene.scene->lights};
  if (last) early_lights_.erase(name);
  const Resident& kept = resident_.try_emplace(name, Resident{std::move(hosted)}).first->second;
  SceneForUse for_use{kept.scene.loaded, SceneUse(kept.uses), kept.pack};
  lock.unlock();
  log::info("scene resident", {{"scene", name},
                               {"device_bytes", on_device->memory_bytes},
                               {"tracer_bytes", on_device->tracer_memory_bytes},
                               {"build_seconds", on_device->tracer_build_seconds},
                               {"from_cache", on_device->tracer_from_cache}});
  request.ready(std::move(for_use));
}

Result<void> SceneHost::unload(const std::string& name) {
  {
    std::lock_guard lock(mutex_);
    const auto found = resident_.find(name);
    if (found == resident_.end()) return Error{"no such scene is resident"};
    const uint32_t users = *found->second.uses;
    if (users > 0) return Error{"sessions use it: " + std::to_string(users)};
    if (on_the_way_.contains(name)) return Error{"it is being loaded"};
    take_away(name);
  }
  log::info("scene unloaded", {{"scene", name}});
  return {};
}

std::vector<std::string> SceneHost::change_sources(SceneCatalog& next, const SceneCatalog& before) {
  std::vector<std::string> kept;
  std::lock_guard lock(mutex_);
  for (const scenes::SceneSource& old : before.sources()) {
    const scenes::SceneSource* const now = next.source(old.name);
    if (now && *now == old) continue;
    if (is_free(old.name)) {
      take_away(old.name);
    } else if (resident_.contains(old.name) || on_the_way_.contains(old.name) || reading_.contains(old.name)) {
      kept.push_back(old.name);
    }
  }
  for (const std::string& name : kept) next.keep(name, before);
  registry_.set_sources(next.sources());
  return kept;
}

void SceneHost::keep_pack(const std::string& name, std::shared_ptr<const ScenePack> pack, uint64_t bytes) {
  std::lock_guard lock(mutex_);
  const auto found = resident_.find(name);
  if (found == resident_.end() || found->second.pack) return;
  found->second.pack = std::move(pack);
  account_.grow(name, bytes);
}

void SceneHost::keep_lights(const LightsUpdate& update) {
  std::lock_guard lock(mutex_);
  const auto found = resident_.find(update.scene);
  if (found == resident_.end() && !on_the_way_.contains(update.scene)) return;
  LightsUpdate& known = found == resident_.end() ? early_lights_[update.scene] : found->second.scene.lights;
  // The slower ones of several devices announce older versions.
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
    scene.account_bytes = account_.bytes_of(name);
  }
  return scenes;
}

std::vector<SceneUnderWay> SceneHost::under_way() const {
  std::lock_guard lock(mutex_);
  std::vector<SceneUnderWay> all;
  for (const auto& [name, counted] : under_way_) {
    SceneUnderWay& scene = all.emplace_back(SceneUnderWay{name, SceneUnderWay::Stage::queued, counted.since});
    if (on_the_way_.contains(name)) {
      scene.stage = SceneUnderWay::Stage::preparing;
    } else if (const auto reading = reading_.find(name); reading != reading_.end()) {
      scene.stage = SceneUnderWay::Stage::reading;
      scene.share = reading->second.share;
    }
  }
  return all;
}

SceneHost::MemoryInUse SceneHost::memory() const {
  std::lock_guard lock(mutex_);
  return {account_.bytes(), account_.limits().all_bytes};
}

void SceneHost::set_memory_limits(SceneMemoryLimits limits) {
  std::lock_guard lock(mutex_);
  account_.set_limits(std::move(limits));
}

}  // namespace gnomon::daemon
