// What makes the daemon's renderers, as the configuration says.
#pragma once

#include "daemon/config.h"
#include "daemon/render_device.h"

namespace gnomon::daemon {

RendererFactory vulkan_renderers(const Config& config);

}  // namespace gnomon::daemon
