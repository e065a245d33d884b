#include "daemon/render/vulkan_renderers.h"

#include <algorithm>

#include "common/log.h"
#include "daemon/config/render_effects.h"
#include "daemon/config/scene_memory.h"
#include "gpu/vulkan_renderer.h"

namespace gnomon::daemon {
namespace {

// Each tenant may have one frame in bands beside the uncut frames; unused slots take no memory.
uint32_t frame_slots(const Config& config) {
  constexpr size_t kMostInBands = 16;
  return config.render.frames_in_flight + static_cast<uint32_t>(std::min(config.tenants.size(), kMostInBands));
}

std::vector<std::string> device_names(const RenderConfig& render) {
  return render.devices.empty() ? std::vector{render.device} : render.devices;
}

std::string selector_of(const std::string& device) { return device == "auto" ? "" : device; }

}  // namespace

std::vector<Error> check_vulkan_renderers(const Config& config) {
  const RenderConfig& render = config.render;
  gpu::RendererOptions options;
  options.tracer = render.tracer;
  if (const auto passes = renderer_passes(render); !passes.empty()) options.passes = passes;
  std::vector<Error> errors;
  for (const std::string& device : device_names(render)) {
    options.device = selector_of(device);
    for (const Error& error : gpu::check_options(options)) {
      const bool of_list = !render.devices.empty() && error.message.starts_with("device: ");
      errors.push_back(Error{of_list ? "render.devices" + error.message.substr(6) : "render." + error.message});
    }
  }
  return errors;
}

uint64_t cache_bytes_of(const RenderConfig& render) {
  return render.cache_mb > 0 ? uint64_t{render.cache_mb} << 20 : UINT64_MAX;
}

std::vector<RendererFactory> vulkan_renderers(const Config& config, const gpu::StructureBuildsPtr& builds,
                                              std::shared_ptr<const std::atomic<uint64_t>> cache_bytes) {
  const RenderConfig& render = config.render;
  gpu::RendererOptions options;
  options.raster = render.raster;
  options.tracer = render.tracer;
  options.tracer_options.cache_folder = render.cache_folder;
  if (!cache_bytes) cache_bytes = std::make_shared<const std::atomic<uint64_t>>(cache_bytes_of(render));
  options.tracer_options.cache_bytes = std::move(cache_bytes);
  options.tracer_options.light_buffer_bytes = uint64_t{render.light_buffer_mb} << 20;
  options.tracer_options.most_light_buffer_room = most_light_buffer_room(config);
  options.tracer_options.builds = builds;
  options.wait_for_builds = render.wait_for_light_buffers;
  if (const auto passes = renderer_passes(render); !passes.empty()) {
    log::warning("deprecated configuration value",
                 {{"key", "render.passes"}, {"value", passes.front()}, {"use", "hard_shadows, soft_shadows"}});
    options.passes = passes;
  }
  options.frames_in_flight = frame_slots(config);
  options.queues = render.queues;
  std::vector<RendererFactory> factories;
  for (const std::string& device : device_names(render)) {
    options.device = selector_of(device);
    factories.push_back([options] { return gpu::make_renderer(options); });
  }
  return factories;
}

}  // namespace gnomon::daemon
