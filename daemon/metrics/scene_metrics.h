// What the daemon counts of its scenes, for Prometheus. Part of Metrics.
//
// Only the configured scenes have series, as clients may ask for any number of files: what is said of others counts
// for none, but frames, which share the label kOtherScenes. Any thread.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/published.h"
#include "daemon/metrics/status.h"
#include "scenes/registry.h"

namespace prometheus {
class Counter;
class Gauge;
class Registry;
template <typename T>
class Family;
}  // namespace prometheus

namespace gnomon::daemon {

inline constexpr const char* kOtherScenes = "other";

class SceneMetrics {
 public:
  // `names`: of the configured scenes.
  SceneMetrics(prometheus::Registry& registry, const std::vector<std::string>& names);

  // Makes the series of those that have none yet.
  void add(const std::vector<std::string>& names);

  void frame_sent(const std::string& scene);
  void resident(const std::string& scene, const scenes::LoadedScene& loaded, const gpu::SceneFootprint& on_device);
  void unloaded(const std::string& scene);
  void lights(const std::string& scene, const gpu::LightState& lights);
  void built(const SceneReport& scene);
  void lights_rebuilt(const std::string& scene);

 private:
  using Gauges = prometheus::Family<prometheus::Gauge>;
  using Counters = prometheus::Family<prometheus::Counter>;

  using BuffersByScene = std::map<std::string, prometheus::Counter*>;

  bool known(const std::string& scene) const { return buffers_.get()->contains(scene); }

  Gauges &resident_, &load_seconds_, &memory_bytes_, &build_seconds_, &device_bytes_, &tracer_bytes_, &from_cache_,
      &kept_, &built_, &lights_;
  Counters &rebuilds_, &all_buffers_;
  Published<BuffersByScene> buffers_;
};

}  // namespace gnomon::daemon
