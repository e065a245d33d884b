#include "tests/unit/gpu/test_device.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <glm/gtc/matrix_transform.hpp>
#include <iterator>

#include "gpu/tracers/tracer.h"
#include "spirv/trace_light_buffer_128_emulated.h"
#include "spirv/trace_light_buffer_16_emulated.h"
#include "spirv/trace_light_buffer_32_emulated.h"
#include "spirv/trace_light_buffer_64_emulated.h"
#include "spirv/trace_soft_light_buffer_128_emulated.h"
#include "spirv/trace_soft_light_buffer_16_emulated.h"
#include "spirv/trace_soft_light_buffer_32_emulated.h"
#include "spirv/trace_soft_light_buffer_64_emulated.h"

namespace gnomon::test {
namespace {

// A tenth of what a scene with two lights may have by itself: made scenes are small, and a build refines until it has
// spent what it may.
constexpr uint64_t kLightBufferBytes = 24 << 20;

}  // namespace

gpu::RendererOptions device_options(const std::string& tracer) {
  gpu::RendererOptions options;
  if (const char* device = std::getenv("GNOMON_TEST_DEVICE")) options.device = device;
  if (const char* raster = std::getenv("GNOMON_TEST_RASTER")) options.raster = raster;
  options.texel_loads = std::getenv("GNOMON_TEST_WITHOUT_TEXELS") == nullptr;
  options.tracer = tracer;
  options.tracer_options.light_buffer_bytes = kLightBufferBytes;
  if (const uint32_t lanes = number_in_environment("GNOMON_TEST_EMULATED_LANES")) {
    options.texel_loads = false;  // as on a GPU
    options.tracer_options.light_buffer_shader = emulated_light_buffer_shader(lanes);
    options.tracer_options.light_buffer_soft_shader = emulated_soft_shader(lanes);
  }
  return options;
}

gpu::RendererOptions full_size_options(const std::string& tracer) {
  gpu::RendererOptions options = device_options(tracer);
  options.tracer_options.light_buffer_bytes = 0;
  return options;
}

gpu::TraceShader emulated_light_buffer_shader(uint32_t lanes) {
  switch (lanes) {
    case 16: return {trace_light_buffer_16_emulated};
    case 32: return {trace_light_buffer_32_emulated};
    case 64: return {trace_light_buffer_64_emulated};
    case 128: return {trace_light_buffer_128_emulated, 0, 2};
    default: std::fprintf(stderr, "no subgroups of %u lanes are emulated\n", lanes); std::abort();
  }
}

gpu::TraceShader emulated_soft_shader(uint32_t lanes) {
  switch (lanes) {
    case 16: return {trace_soft_light_buffer_16_emulated};
    case 32: return {trace_soft_light_buffer_32_emulated};
    case 64: return {trace_soft_light_buffer_64_emulated};
    case 128: return {trace_soft_light_buffer_128_emulated, 0, 2};
    default: std::fprintf(stderr, "no subgroups of %u lanes are emulated\n", lanes); std::abort();
  }
}

uint32_t number_in_environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? static_cast<uint32_t>(std::strtoul(value, nullptr, 10)) : 0;
}

std::vector<std::string> tracers() {
  static const std::vector<std::string> offered = [] {
    std::vector<std::string> names;
    const auto device = gpu::Device::create({device_options().device, {}});
    const char* only = std::getenv("GNOMON_TEST_TRACERS");
    if (only && std::ranges::find(gpu::kTracers, std::string_view(only)) == std::end(gpu::kTracers)) {
      std::fprintf(stderr, "GNOMON_TEST_TRACERS: there is no tracer %s\n", only);  // a test of no tracer is true
      std::abort();
    }
    for (const std::string_view tracer : gpu::kTracers) {
      const std::string name(tracer);
      if (only && name != only) continue;
      if (device && gpu::make_tracer(name, *device)) {
        names.push_back(name);
      } else {
        std::printf("skipped: tracer %s, which this device does not offer\n", name.c_str());
      }
    }
    return names;
  }();
  return offered;
}

gpu::CameraView look_at(glm::vec3 eye, glm::vec3 target, float vertical_fov, uint32_t width, uint32_t height) {
  const glm::vec3 forward = glm::normalize(target - eye);
  const glm::vec3 up = std::abs(forward.y) > 0.99f ? glm::vec3(0, 0, 1) : glm::vec3(0, 1, 0);
  gpu::CameraView view;
  view.position = eye;
  view.orientation = glm::normalize(glm::quat_cast(glm::inverse(glm::lookAt(eye, target, up))));
  view.tan_up = view.tan_down = std::tan(vertical_fov / 2);
  view.tan_left = view.tan_right = view.tan_up * static_cast<float>(width) / static_cast<float>(height);
  return view;
}

}  // namespace gnomon::test
