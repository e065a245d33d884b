// The memory that a scene is expected to take, for the account of scenes.
#pragma once

#include <cstdint>
#include <span>

#include "daemon/render/device_pool.h"
#include "scenes/scene.h"

namespace gnomon::daemon {

// Bytes, on the host and on the device where it may take most. `light_buffer_bytes`: render.light_buffer_mb; 0: by the
// number of lights and the devices' room.
uint64_t expected_memory(const scenes::Scene& scene, uint64_t light_buffer_bytes,
                         std::span<const PooledDevice> devices);

}  // namespace gnomon::daemon
