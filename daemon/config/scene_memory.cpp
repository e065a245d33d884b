#include "daemon/config/scene_memory.h"

#include <algorithm>

#include "daemon/config/machine_memory.h"

namespace gnomon::daemon {

uint64_t scene_memory_bytes(const Config& config) {
  const uint64_t configured = uint64_t{config.scenes.max_memory_mb} << 20;
  return configured != 0 ? configured : usable_memory_bytes() / 2;
}

uint64_t most_light_buffer_room(const Config& config) {
  constexpr uint64_t kScenes = 16, kScenesOfTenant = 4;
  uint64_t most = scene_memory_bytes(config) / kScenes;
  for (const TenantConfig& tenant : config.tenants) {
    const uint64_t own = uint64_t{tenant.max_scene_memory_mb} << 20;
    if (own != 0) most = std::min(most, own / kScenesOfTenant);
  }
  return most;
}

}  // namespace gnomon::daemon
