// What changes in the scenes of a device: the clock that their animations play on, and lights that operators change.
//
// A light that was changed is answered for at once, exactly; when the light has rested for a while, what the tracer
// builds for lights is rebuilt beside the frames. All of it belongs to the render thread and is told the time.
#pragma once

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
    TimePoint clock_start{};  // of all scenes
  };

  // References outlive this. `sink` hears of other lights as soon as frames are of them.
  SceneMotion(RenderDevice& device, Metrics& metrics, FrameSink& sink)
      : device_(device), metrics_(metrics), sink_(sink) {}
  void configure(const Settings& settings) { settings_ = settings; }

  // The scene was made resident. If the tracer has not built for its lights yet, it does so from now on. Idempotent.
  void add(SceneId id, const std::string& name, const scenes::LoadedScene& scene);

  void remove(SceneId id) { scenes_.erase(id); }

  scenes::SceneTime time_of(SceneId scene, TimePoint now) const;
  // The lights as the last change wants them, animated ones at time 0; empty if there is no such scene.
  std::span<const scenes::Light> lights_of(SceneId scene) const;
  // Nullopt if the scene never differs from its file.
  std::optional<protocol::Moment> moment_of(SceneId scene, TimePoint now) const;

  // Changes to unknown scenes and lights are ignored.
  void change(SceneId scene, uint32_t light, const LightChange& change, TimePoint now);
  // Takes over what was done beside the frames, and starts what is due. Returns the scenes that were unbuilt() until
  // now: their frames cost something else from here on.
  std::vector<SceneId> step(TimePoint now);
  // The device was made anew, with the scenes' own lights.
  void restore();

  // A hierarchy answers for the scene's lights, as what the tracer builds for them is not there yet.
  bool unbuilt(SceneId scene) const;
  SceneReports report() const;

 private:
  struct State {
    std::string name;
    scenes::LoadedScene loaded;
    std::vector<scenes::Light> wanted;  // lights
    uint32_t asked = 0, applied = 0;    // changes; counted
    uint32_t version = 0;               // changes in the lights that frames are of: the same on every device
    bool applying = false, settling = false;
    bool unbuilt = false, failed = false;
    std::optional<TimePoint> changed_at;  // nothing was built for these lights yet
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
