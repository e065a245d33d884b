// The factories of the daemon's renderers, by the configuration.
#pragma once

#include <atomic>
#include <memory>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/render/render_device.h"
#include "gpu/builds/structure_builds.h"

namespace gnomon::daemon {

// One factory for each device that the configuration names, in its order; a device's number is its index in this list.
// `builds`: how what traces a scene is built. `cache_bytes`: as in TracerOptions, for a limit that may change; nullptr: the
// configuration's.
std::vector<RendererFactory> vulkan_renderers(const Config& config,
                                              const gpu::StructureBuildsPtr& builds = gpu::builds_here(),
                                              std::shared_ptr<const std::atomic<uint64_t>> cache_bytes = nullptr);

// Of render.cache_mb.
uint64_t cache_bytes_of(const RenderConfig& render);

// What is wrong with the configuration's devices, tracer and passes, as far as it can be told without opening a device.
std::vector<Error> check_vulkan_renderers(const Config& config);

}  // namespace gnomon::daemon
