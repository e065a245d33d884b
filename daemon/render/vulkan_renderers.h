// What makes the daemon's renderers, as the configuration says.
#pragma once

#include <vector>

#include "daemon/config/config.h"
#include "daemon/render/render_device.h"

namespace gnomon::daemon {

// One for each device that it names, in its order; the numbers of devices are places in this list.
std::vector<RendererFactory> vulkan_renderers(const Config& config);

}  // namespace gnomon::daemon
