// Which device and tracers the tests run on, and how they look at a scene.
#pragma once

#include <string>
#include <vector>

#include "gpu/vulkan_renderer.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::test {

// The device that GNOMON_TEST_DEVICE selects, else the best one; rasterised as GNOMON_TEST_RASTER says; with the shader
// of light buffers that is for subgroups of GNOMON_TEST_EMULATED_LANES lanes, emulated, instead of the device's own. With a small budget for light buffers.
gpu::RendererOptions device_options(const std::string& tracer = "auto");
// With the budget that a scene has by itself.
gpu::RendererOptions full_size_options(const std::string& tracer = "auto");

// The tracer "light_buffer" for subgroups of that many lanes, which the invocations of a workgroup stand for.
// Precondition: lanes is 16, 32, 64 or 128.
gpu::TraceShader emulated_light_buffer_shader(uint32_t lanes);

// Likewise, for area lights.
gpu::TraceShader emulated_soft_shader(uint32_t lanes);

// The value of an environment variable that has a number; 0 if it is not set.
uint32_t number_in_environment(const char* name);

// Every tracer that the test device offers, or that one of GNOMON_TEST_TRACERS. Printed once where one is missing.
std::vector<std::string> tracers();

// A camera at `eye` that looks at `target`; field of view in radians.
gpu::CameraView look_at(glm::vec3 eye, glm::vec3 target, float vertical_fov, uint32_t width, uint32_t height);

}  // namespace gnomon::test
