#include "daemon/scenes/expected_memory.h"

#include <algorithm>

#include "gpu/tracers/light_buffer/builder.h"
#include "scenes/geometry/geometry.h"
#include "scenes/light_samples.h"

namespace gnomon::daemon {
namespace {

uint64_t light_buffers(const scenes::Scene& scene, std::span<const PooledDevice> devices) {
  uint64_t room = 0;
  for (const PooledDevice& device : devices) room = std::max(room, device.light_buffer_room);
  const uint64_t parts = scenes::has_area_lights(scene) ? 2 : 1;  // lights with an extent have buffers of their own
  return parts * gpu::light_buffer::default_budget(scene.lights.size(), room / parts);
}

}  // namespace

uint64_t expected_memory(const scenes::Scene& scene, uint64_t light_buffer_bytes,
                         std::span<const PooledDevice> devices) {
  return scenes::predicted_bytes(scene) +
         (light_buffer_bytes != 0 ? light_buffer_bytes : light_buffers(scene, devices));
}

}  // namespace gnomon::daemon
