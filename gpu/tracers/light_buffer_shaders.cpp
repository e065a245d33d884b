#include "gpu/tracers/light_buffer_shaders.h"

#include <algorithm>

#include "spirv/trace_light_buffer_128_comp.h"
#include "spirv/trace_light_buffer_16_comp.h"
#include "spirv/trace_light_buffer_16_texels_comp.h"
#include "spirv/trace_light_buffer_32_comp.h"
#include "spirv/trace_light_buffer_4_comp.h"
#include "spirv/trace_light_buffer_4_texels_comp.h"
#include "spirv/trace_light_buffer_64_comp.h"
#include "spirv/trace_light_buffer_8_comp.h"
#include "spirv/trace_light_buffer_8_texels_comp.h"
#include "spirv/trace_soft_light_buffer_128_comp.h"
#include "spirv/trace_soft_light_buffer_16_comp.h"
#include "spirv/trace_soft_light_buffer_16_texels_comp.h"
#include "spirv/trace_soft_light_buffer_32_comp.h"
#include "spirv/trace_soft_light_buffer_4_comp.h"
#include "spirv/trace_soft_light_buffer_4_texels_comp.h"
#include "spirv/trace_soft_light_buffer_64_comp.h"
#include "spirv/trace_soft_light_buffer_8_comp.h"
#include "spirv/trace_soft_light_buffer_8_texels_comp.h"

namespace gnomon::gpu {
namespace {

constexpr uint32_t kTexelBuffers = 4;  // grid, leaves, and of the entries their bounds and triangles

TraceShader narrow(uint32_t lanes, bool by_texels, std::span<const uint32_t> texels,
                   std::span<const uint32_t> other) {
  return by_texels ? TraceShader{texels, lanes, 1, kTexelBuffers} : TraceShader{other, lanes};
}

}  // namespace

std::optional<TraceShader> light_buffer_shader(uint32_t lanes, bool by_texels) {
  switch (lanes) {
    case 4: return narrow(lanes, by_texels, trace_light_buffer_4_texels_comp, trace_light_buffer_4_comp);
    case 8: return narrow(lanes, by_texels, trace_light_buffer_8_texels_comp, trace_light_buffer_8_comp);
    case 16: return narrow(lanes, by_texels, trace_light_buffer_16_texels_comp, trace_light_buffer_16_comp);
    case 32: return TraceShader{trace_light_buffer_32_comp, lanes};
    case 64: return TraceShader{trace_light_buffer_64_comp, lanes};
    case 128: return TraceShader{trace_light_buffer_128_comp, lanes, 2};
    default: return std::nullopt;
  }
}

std::optional<TraceShader> light_buffer_shader(const DeviceFeatures& features) {
  const SubgroupFeatures& subgroups = features.subgroups;
  if (!subgroups.ballots_and_votes) return std::nullopt;
  return light_buffer_shader(std::clamp(16u, subgroups.least, subgroups.most), features.loads_texels());
}

std::optional<TraceShader> light_buffer_soft_shader(uint32_t lanes, bool by_texels) {
  switch (lanes) {
    case 4: return narrow(lanes, by_texels, trace_soft_light_buffer_4_texels_comp, trace_soft_light_buffer_4_comp);
    case 8: return narrow(lanes, by_texels, trace_soft_light_buffer_8_texels_comp, trace_soft_light_buffer_8_comp);
    case 16:
      return narrow(lanes, by_texels, trace_soft_light_buffer_16_texels_comp, trace_soft_light_buffer_16_comp);
    case 32: return TraceShader{trace_soft_light_buffer_32_comp, lanes};
    case 64: return TraceShader{trace_soft_light_buffer_64_comp, lanes};
    case 128: return TraceShader{trace_soft_light_buffer_128_comp, lanes, 2};
    default: return std::nullopt;
  }
}

}  // namespace gnomon::gpu
