#include "gpu/tracers/light_buffer_shaders.h"

#include <algorithm>

#include "spirv/trace_light_buffer_128_comp.h"
#include "spirv/trace_light_buffer_16_comp.h"
#include "spirv/trace_light_buffer_16_pairs_comp.h"
#include "spirv/trace_light_buffer_32_comp.h"
#include "spirv/trace_light_buffer_4_comp.h"
#include "spirv/trace_light_buffer_4_pairs_comp.h"
#include "spirv/trace_light_buffer_64_comp.h"
#include "spirv/trace_light_buffer_8_comp.h"
#include "spirv/trace_light_buffer_8_pairs_comp.h"
#include "spirv/trace_soft_light_buffer_128_comp.h"
#include "spirv/trace_soft_light_buffer_16_comp.h"
#include "spirv/trace_soft_light_buffer_16_pairs_comp.h"
#include "spirv/trace_soft_light_buffer_32_comp.h"
#include "spirv/trace_soft_light_buffer_4_comp.h"
#include "spirv/trace_soft_light_buffer_4_pairs_comp.h"
#include "spirv/trace_soft_light_buffer_64_comp.h"
#include "spirv/trace_soft_light_buffer_8_comp.h"
#include "spirv/trace_soft_light_buffer_8_pairs_comp.h"

namespace gnomon::gpu {
namespace {

std::span<const uint32_t> pick(bool first, std::span<const uint32_t> a, std::span<const uint32_t> b) {
  return first ? a : b;
}

}  // namespace

std::optional<TraceShader> light_buffer_shader(uint32_t lanes, bool by_pairs) {
  switch (lanes) {
    case 4: return TraceShader{pick(by_pairs, trace_light_buffer_4_pairs_comp, trace_light_buffer_4_comp), lanes};
    case 8: return TraceShader{pick(by_pairs, trace_light_buffer_8_pairs_comp, trace_light_buffer_8_comp), lanes};
    case 16:
      return TraceShader{pick(by_pairs, trace_light_buffer_16_pairs_comp, trace_light_buffer_16_comp), lanes};
    case 32: return TraceShader{trace_light_buffer_32_comp, lanes};
    case 64: return TraceShader{trace_light_buffer_64_comp, lanes};
    case 128: return TraceShader{trace_light_buffer_128_comp, lanes, 2};
    default: return std::nullopt;
  }
}

std::optional<TraceShader> light_buffer_shader(const DeviceFeatures& features) {
  const SubgroupFeatures& subgroups = features.subgroups;
  if (!subgroups.ballots_and_votes) return std::nullopt;
  return light_buffer_shader(std::clamp(16u, subgroups.least, subgroups.most), features.loads_pairs());
}

std::optional<TraceShader> light_buffer_soft_shader(uint32_t lanes, bool by_pairs) {
  switch (lanes) {
    case 4:
      return TraceShader{pick(by_pairs, trace_soft_light_buffer_4_pairs_comp, trace_soft_light_buffer_4_comp),
                         lanes};
    case 8:
      return TraceShader{pick(by_pairs, trace_soft_light_buffer_8_pairs_comp, trace_soft_light_buffer_8_comp),
                         lanes};
    case 16:
      return TraceShader{pick(by_pairs, trace_soft_light_buffer_16_pairs_comp, trace_soft_light_buffer_16_comp),
                         lanes};
    case 32: return TraceShader{trace_soft_light_buffer_32_comp, lanes};
    case 64: return TraceShader{trace_soft_light_buffer_64_comp, lanes};
    case 128: return TraceShader{trace_soft_light_buffer_128_comp, lanes, 2};
    default: return std::nullopt;
  }
}

}  // namespace gnomon::gpu
