// Chooses how the G-buffer is rasterised: by the graphics pipeline, or in compute (shaders/raster.glsl).
//
// Compute accelerators have few graphics units, so that the pipeline's fixed functions limit a frame. Other devices
// draw faster than a shader can. Hence both are measured.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "gpu/vulkan/device.h"

namespace gnomon::gpu {

// Returns "hardware" or "compute". `wanted`: one of these, or "auto" for the faster one on a generated scene of many
// small triangles, which takes some frames. "auto" is "hardware" without a trial if the device is a CPU or lacks what
// "compute" needs. Blocking. Error: `wanted` is another word, the device lacks what "compute" needs, or out of memory.
Result<std::string> choose_raster(const DevicePtr& device, std::string_view wanted);

// The pass list with its "gbuffer" replaced by the pass of that way.
std::vector<std::string> with_raster(std::vector<std::string> passes, std::string_view raster);

}  // namespace gnomon::gpu
