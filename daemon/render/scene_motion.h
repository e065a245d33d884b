// What changes in the scenes of a device: the clock that drives their animations, and the lights that operators change.
//
// A changed light is traced exactly at once, with a hierarchy; when the scene's lights have rested for a while, their
// light buffers are rebuilt in the background. All of it belongs to the render thread; the caller passes the time.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "daemon/frame/frame_sink.h"
#include "daemon/metrics/metrics.h"
#include "daemon/metrics/status.h"
#include "daemon/render/light_change.h"
#include "daemon/render/render_device.h"
#include "protocol/types.h"
#include "scenes/motion.h"

namespace gnomon::daemon {

class SceneMotion {
 public:
  struct Settings {
    uint32_t clock_hz = 60;
    Nanoseconds light_rest = std::chrono::seconds(2);
    TimePoint clock_start{};  // time 0 of all scenes
  };

  // All references outlive this object. FrameSink::on_lights is called as soon as frames use changed lights.
  SceneMotion(RenderDevice& device, Metrics& metrics, FrameSink& sink)
      : device_(device), metrics_(metrics), sink_(sink) {}
  void configure(const Settings& settings) { settings_ = settings; }

  // The scene was made resident. If its light buffers are not built yet, their build starts now. Idempotent.
  void add(SceneId id, const std::string& name, const scenes::LoadedScene& scene);

  // The lights as operators have changed them before the scene was added; of version 0 they are the file's. Calls
  // `shown` when frames use lights at least as new, at once if they do.
  void show(SceneId id, const LightsUpdate& lights, std::function<void()> shown);
  // Calls what waits for changed lights, as nobody knows when they are there: the device is lost, or the end has come.
  void answer_waiting();

  void remove(SceneId id) { scenes_.erase(id); }

  scenes::SceneTime time_of(SceneId scene, TimePoint now) const;
  // The lights after the last requested change, animated ones at time 0; empty if there is no such scene.
  std::span<const scenes::Light> lights_of(SceneId scene) const;
  // The moment that a frame of now shows; nullopt if the scene has no motion and its lights were never changed.
  std::optional<protocol::Moment> moment_of(SceneId scene, TimePoint now) const;

  // Changes to unknown scenes and lights are ignored, and so is one whose version has been shown already.
  void change(SceneId scene, uint32_t light, const LightChange& change, TimePoint now, uint32_t version);
  // Takes over what was finished in the background, and starts what is due. Returns the scenes that were unbuilt()
  // until now, as the cost of their frames changes.
  std::vector<SceneId> step(TimePoint now);
  // The device was rebuilt, with the lights of the scene files: applies the changes again.
  void restore();

  // The scene's lights are traced with a hierarchy, as their light buffers are not built yet.
  bool unbuilt(SceneId scene) const;
  SceneReports report() const;

 private:
  struct State {
    std::string name;
    scenes::LoadedScene loaded;
    std::vector<scenes::Light> wanted;  // lights
    uint32_t asked = 0;                 // version of `wanted`
    uint32_t version = 0;               // of the lights that frames use; the same on every device
    bool applying = false, settling = false;
    bool unbuilt = false, failed = false;
    std::vector<std::function<void()>> waiting;  // until `applying` is over
    std::optional<TimePoint> changed_at;         // of the last change for which no light buffers are built yet
    uint32_t failures = 0;                       // of builds, in turn
    std::optional<TimePoint> again_at;           // when the build that has failed is tried again
  };

  void apply(SceneId id, State& state);
  void settle(SceneId id, State& state);
  void settled(SceneId id, State& state, const Result<void>& done);
  void look_for_unbuilt(SceneId id, State& state);
  void count(SceneId id, const State& state);

  RenderDevice& device_;
  Metrics& metrics_;
  FrameSink& sink_;
  Settings settings_;
  std::map<SceneId, State> scenes_;
  std::vector<SceneId> built_;  // since the last step
};

}  // namespace gnomon::daemon
