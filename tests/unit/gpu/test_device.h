// Which device and tracers the tests run on, and how they look at a scene.
#pragma once

#include <string>
#include <vector>

#include "gpu/vulkan_renderer.h"
#include "tests/unit/gpu/surface_probe.h"

namespace gnomon::test {

// The device that GNOMON_TEST_DEVICE selects, else the best one; rasterised as GNOMON_TEST_RASTER says.
gpu::RendererOptions device_options(const std::string& tracer = "auto");

// Every tracer that the test device offers, or that one of GNOMON_TEST_TRACERS. Printed once where one is missing.
std::vector<std::string> tracers();

// A camera at `eye` that looks at `target`; field of view in radians.
gpu::CameraView look_at(glm::vec3 eye, glm::vec3 target, float vertical_fov, uint32_t width, uint32_t height);

}  // namespace gnomon::test
