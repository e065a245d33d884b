#include "gpu/tracers/tracer.h"

namespace gnomon::gpu {
namespace {

// Ray queries where hardware answers them. A CPU's are software: there lavapipe's own take twice as long as `bvh`.
bool prefers_ray_query(const Device& device) {
  return device.features().ray_query && device.info().type != VK_PHYSICAL_DEVICE_TYPE_CPU;
}

}  // namespace

Result<std::unique_ptr<Tracer>> make_tracer(std::string_view name, const DevicePtr& device,
                                            const TracerOptions& options) {
  if (name == "auto") name = prefers_ray_query(*device) ? "ray_query" : "bvh";
  if (name == "bvh") return make_bvh_tracer(device);
  if (name == "light_buffer") return make_light_buffer_tracer(device, options);
  if (name == "ray_query") return make_ray_query_tracer(device);
  return Error{"no tracer is called '" + std::string(name) + "'; there are auto, bvh, light_buffer, ray_query"};
}

}  // namespace gnomon::gpu
