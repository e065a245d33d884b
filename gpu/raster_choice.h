// Which way the G-buffer is rasterised: by the graphics pipeline, or in compute (shaders/raster.glsl).
//
// Cards for computing have few graphics units: there the pipeline's fixed parts are what a frame waits for. Others draw
// faster than any shader could. So both are tried.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "gpu/vulkan/device.h"

namespace gnomon::gpu {

// "hardware" or "compute". `wanted`: one of these, or "auto": the faster one on a made scene of many small triangles,
// which takes some frames; without a trial "hardware" where a processor does both, or compute lacks what it needs.
// Error: another word, a device that lacks what "compute" needs, or out of memory.
Result<std::string> choose_raster(const DevicePtr& device, std::string_view wanted);

// The pass list with its "gbuffer" drawn that way.
std::vector<std::string> with_raster(std::vector<std::string> passes, std::string_view raster);

}  // namespace gnomon::gpu
