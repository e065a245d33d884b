// The factories of the daemon's renderers, by the configuration.
#pragma once

#include <vector>

#include "daemon/config/config.h"
#include "daemon/render/render_device.h"

namespace gnomon::daemon {

// One factory for each device that the configuration names, in its order; a device's number is its index in this list.
std::vector<RendererFactory> vulkan_renderers(const Config& config);

}  // namespace gnomon::daemon
