// The memory of scenes, by the configuration and the machine.
#pragma once

#include <cstdint>

#include "daemon/config/config.h"

namespace gnomon::daemon {

// Bytes: scenes.max_memory_mb, or what stands for it where it is 0.
uint64_t scene_memory_bytes(const Config& config);

// The most, in bytes, that the light buffers of one scene may take because a device has room for them: many scenes fit
// into what all of them may have, and a few into what a tenant may bring.
uint64_t most_light_buffer_room(const Config& config);

}  // namespace gnomon::daemon
