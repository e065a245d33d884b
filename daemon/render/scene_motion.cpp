#include "daemon/render/scene_motion.h"

#include <algorithm>
#include <utility>

namespace gnomon::daemon {
namespace {

// A build that failed may have been ended for want of memory, or for the time that it took on a busy machine.
Nanoseconds rest_after(uint32_t failures) {
  constexpr uint32_t kMostDoublings = 6;
  return std::chrono::minutes(1) * (1 << std::min(failures - 1, kMostDoublings));
}

}  // namespace

void SceneMotion::add(SceneId id, const std::string& name, const scenes::LoadedScene& scene) {
  if (scenes_.contains(id)) return;
  State& state = scenes_[id];
  state.name = name;
  state.loaded = scene;
  state.wanted = scene.scene->lights;
  look_for_unbuilt(id, state);
  count(id, state);
}

void SceneMotion::show(SceneId id, const LightsUpdate& lights, std::function<void()> shown) {
  State& state = scenes_.at(id);
  if (lights.version > state.asked) {
    state.wanted = lights.lights;
    state.asked = lights.version;
    state.changed_at = TimePoint{};  // long ago: nobody is about to change them once more
    state.waiting.push_back(std::move(shown));
    if (!state.applying) apply(id, state);
  } else if (state.applying) {
    state.waiting.push_back(std::move(shown));
  } else {
    shown();
  }
}

void SceneMotion::answer_waiting() {
  for (auto& [id, state] : scenes_) {
    for (const auto& shown : std::exchange(state.waiting, {})) shown();
  }
}

void SceneMotion::look_for_unbuilt(SceneId id, State& state) {
  state.unbuilt = device_.renderer().light_state(id).unbuilt > 0;
  if (state.unbuilt) settle(id, state);
}

bool SceneMotion::unbuilt(SceneId scene) const {
  const auto found = scenes_.find(scene);
  return found != scenes_.end() && found->second.unbuilt;
}

SceneReports SceneMotion::report() const {
  SceneReports reports;
  const gpu::Renderer& renderer = device_.renderer();
  for (const auto& [id, state] : scenes_) {
    reports[id] = {state.name, renderer.footprint(id), renderer.light_state(id), renderer.build_progress(id),
                   state.failed};
  }
  return reports;
}

std::span<const scenes::Light> SceneMotion::lights_of(SceneId scene) const {
  const auto found = scenes_.find(scene);
  if (found == scenes_.end()) return {};
  return found->second.wanted;
}

// The clock advances in steps of 1 / clock_hz, so that frames within one step show the same moment.
scenes::SceneTime SceneMotion::time_of(SceneId scene, TimePoint now) const {
  const auto found = scenes_.find(scene);
  if (found == scenes_.end()) return {};
  constexpr int64_t kMicroseconds = 1'000'000;
  const int64_t steps = to_microseconds(now - settings_.clock_start) * settings_.clock_hz / kMicroseconds;
  const scenes::SceneTime time(steps * kMicroseconds / settings_.clock_hz);
  return scenes::within_period(*found->second.loaded.scene, time);
}

std::optional<protocol::Moment> SceneMotion::moment_of(SceneId scene, TimePoint now) const {
  const auto found = scenes_.find(scene);
  if (found == scenes_.end()) return std::nullopt;
  const State& state = found->second;
  if (!scenes::moves(*state.loaded.scene) && state.version == 0) return std::nullopt;
  return protocol::Moment{static_cast<uint32_t>(time_of(scene, now).count()), state.version};
}

void SceneMotion::change(SceneId scene, uint32_t light, const LightChange& change, TimePoint now,
                         uint32_t version) {
  const auto found = scenes_.find(scene);
  if (found == scenes_.end() || light >= found->second.wanted.size()) return;
  State& state = found->second;
  if (version <= state.asked) return;
  const auto changed = changed_light(state.wanted[light], state.loaded.scene->lights[light], change);
  if (!changed) return;
  state.wanted[light] = *changed;
  state.asked = version;
  state.changed_at = now;
  if (!state.applying) apply(scene, state);
}

void SceneMotion::apply(SceneId id, State& state) {
  state.applying = true;
  const uint32_t asked = state.asked;
  const auto changed = [this, id, asked, lights = state.wanted](Result<void> done) {
    const auto found = scenes_.find(id);
    if (found == scenes_.end()) return;  // unloaded meanwhile
    State& s = found->second;
    s.applying = false;
    if (done) {
      s.version = asked;
      log::info("lights changed", {{"scene", s.name}, {"version", s.version}});
      sink_.on_lights({s.name, s.version, lights});
      count(id, s);
    } else {
      log::error("lights not changed", {{"scene", s.name}, {"why", done.error().message}});
    }
    if (s.asked != asked) return apply(id, s);  // changed once more meanwhile
    for (const auto& shown : std::exchange(s.waiting, {})) shown();
  };
  device_.renderer().set_lights(id, state.wanted, changed, device_.wake());
}

void SceneMotion::settle(SceneId id, State& state) {
  state.settling = true;
  state.failed = false;
  state.again_at.reset();
  const auto done = [this, id, scene = state.loaded.scene,
                     changed_at = state.changed_at](const Result<void>& built) {
    const auto found = scenes_.find(id);
    if (found == scenes_.end() || found->second.loaded.scene != scene) return;  // unloaded meanwhile
    if (found->second.changed_at == changed_at) found->second.changed_at.reset();
    settled(id, found->second, built);
  };
  device_.renderer().rebuild_lights(id, done, device_.wake());
}

void SceneMotion::settled(SceneId id, State& state, const Result<void>& done) {
  state.settling = false;
  state.failed = !done;
  state.failures = done ? 0 : state.failures + 1;
  if (!done) return log::error("light buffers not built", {{"scene", state.name}, {"why", done.error().message}});
  if (std::exchange(state.unbuilt, false)) {
    built_.push_back(id);
  } else {
    metrics_.scenes().lights_rebuilt(state.name);
  }
  count(id, state);
}

std::vector<SceneId> SceneMotion::step(TimePoint now) {
  device_.renderer().finish_background();
  for (auto& [id, state] : scenes_) {
    if (state.failed && !state.again_at) state.again_at = now + rest_after(state.failures);
    const bool rested = state.changed_at && now - *state.changed_at >= settings_.light_rest;
    const bool again = state.again_at && now >= *state.again_at;
    if ((rested || again) && !state.applying && !state.settling) settle(id, state);
  }
  return std::exchange(built_, {});
}

void SceneMotion::restore() {
  for (auto& [id, state] : scenes_) {
    state.applying = state.settling = false;
    if (state.asked > 0) apply(id, state);
    look_for_unbuilt(id, state);
    count(id, state);
  }
}

void SceneMotion::count(SceneId id, const State& state) {
  metrics_.scenes().resident(state.name, state.loaded, device_.renderer().footprint(id));
  metrics_.scenes().lights(state.name, device_.renderer().light_state(id));
}

}  // namespace gnomon::daemon
