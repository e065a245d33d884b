#include "daemon/metrics/scene_metrics.h"

#include "daemon/metrics/prometheus_families.h"

namespace gnomon::daemon {

SceneMetrics::SceneMetrics(prometheus::Registry& registry, const std::vector<std::string>& names)
    : resident_(gauge_family(registry, "gnomon_scene_resident", "1: the scene is on the device, 0: it is not.")),
      load_seconds_(gauge_family(registry, "gnomon_scene_load_seconds",
                                 "Time that reading the scene took, when it was last loaded.")),
      memory_bytes_(gauge_family(registry, "gnomon_scene_memory_bytes", "Host memory that the scene occupies.")),
      build_seconds_(
          gauge_family(registry, "gnomon_scene_build_seconds", "Time that building what the tracer needs took.")),
      device_bytes_(
          gauge_family(registry, "gnomon_scene_device_memory_bytes", "Device memory that the scene occupies.")),
      tracer_bytes_(gauge_family(registry, "gnomon_scene_tracer_memory_bytes",
                                 "Device memory of what the tracer built, as light buffers.")),
      from_cache_(gauge_family(registry, "gnomon_scene_light_buffer_cached",
                               "1: the light buffers were read from the cache, 0: built.")),
      kept_(gauge_family(
          registry, "gnomon_scene_light_buffer_kept",
          "0: the cache did not take the light buffers, and the next start builds them again; else 1.")),
      built_(gauge_family(registry, "gnomon_scene_light_buffers_built_ratio",
                          "Share of the light buffers' build that is done; until 1, frames cost more.")),
      lights_(gauge_family(
          registry, "gnomon_scene_lights",
          "Lights, by state: resting where the tracer built for them, moving, or waiting for the first build.")),
      rebuilds_(counter_family(registry, "gnomon_scene_light_rebuilds_total",
                               "Times that light buffers were built anew for changed lights.")),
      all_buffers_(
          counter_family(registry, "gnomon_scene_visibility_buffers_total", "Visibility buffers sent, by scene.")) {
  add({kOtherScenes});
  add(names);
}

void SceneMetrics::add(const std::vector<std::string>& names) {
  BuffersByScene buffers = *buffers_.get();
  for (const std::string& name : names) buffers.try_emplace(name, &all_buffers_.Add({{"scene", name}}));
  buffers_.publish(std::move(buffers));
}

void SceneMetrics::frame_sent(const std::string& scene) {
  const auto buffers = buffers_.get();
  const auto found = buffers->find(scene);
  (found != buffers->end() ? found->second : buffers->at(kOtherScenes))->Increment();
}

void SceneMetrics::resident(const std::string& scene, const scenes::LoadedScene& loaded,
                            const gpu::SceneFootprint& on_device) {
  if (!known(scene)) return;
  const prometheus::Labels labels{{"scene", scene}};
  resident_.Add(labels).Set(1);
  load_seconds_.Add(labels).Set(loaded.load_seconds);
  build_seconds_.Add(labels).Set(on_device.tracer_build_seconds);
  memory_bytes_.Add(labels).Set(static_cast<double>(loaded.memory_bytes));
  device_bytes_.Add(labels).Set(static_cast<double>(on_device.memory_bytes));
  tracer_bytes_.Add(labels).Set(static_cast<double>(on_device.tracer_memory_bytes));
  from_cache_.Add(labels).Set(on_device.tracer_from_cache ? 1 : 0);
  kept_.Add(labels).Set(on_device.tracer_not_kept ? 0 : 1);
}

void SceneMetrics::unloaded(const std::string& scene) {
  if (!known(scene)) return;
  for (Gauges* family : {&resident_, &memory_bytes_, &device_bytes_, &tracer_bytes_}) {
    family->Add({{"scene", scene}}).Set(0);
  }
}

void SceneMetrics::lights(const std::string& scene, const gpu::LightState& lights) {
  if (!known(scene)) return;
  lights_.Add({{"scene", scene}, {"state", "resting"}}).Set(lights.resting);
  lights_.Add({{"scene", scene}, {"state", "moving"}}).Set(lights.moving);
  lights_.Add({{"scene", scene}, {"state", "unbuilt"}}).Set(lights.unbuilt);
  rebuilds_.Add({{"scene", scene}});
}

void SceneMetrics::built(const SceneReport& scene) {
  if (known(scene.name)) built_.Add({{"scene", scene.name}}).Set(scene.built_share());
}

void SceneMetrics::lights_rebuilt(const std::string& scene) {
  if (known(scene)) rebuilds_.Add({{"scene", scene}}).Increment();
}

}  // namespace gnomon::daemon
