// The shaders of the tracer "light_buffer": one for each size of subgroups.
#pragma once

#include <optional>

#include "gpu/tracers/tracer_options.h"
#include "gpu/vulkan/device_features.h"

namespace gnomon::gpu {

// nullopt: there is none for subgroups of that many lanes. `by_texels`: the one that loads texels, which makes a
// difference on narrow subgroups alone.
std::optional<TraceShader> light_buffer_shader(uint32_t lanes, bool by_texels = false);

// The one for a device's subgroups. Of several sizes it takes 16 lanes or the next wider: a subgroup ends with its
// longest list, so that the narrower waits less, while below 16 lanes each would hold more than four pixels in its
// registers. nullopt: there is none for these subgroups.
std::optional<TraceShader> light_buffer_shader(const DeviceFeatures& features);

// As light_buffer_shader, for area lights.
std::optional<TraceShader> light_buffer_soft_shader(uint32_t lanes, bool by_texels = false);

}  // namespace gnomon::gpu
