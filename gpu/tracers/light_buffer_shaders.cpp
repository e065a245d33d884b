#include "gpu/tracers/light_buffer_shaders.h"

#include <algorithm>

#include "spirv/trace_light_buffer_128_comp.h"
#include "spirv/trace_light_buffer_16_comp.h"
#include "spirv/trace_light_buffer_32_comp.h"
#include "spirv/trace_light_buffer_4_comp.h"
#include "spirv/trace_light_buffer_64_comp.h"
#include "spirv/trace_light_buffer_8_comp.h"
#include "spirv/trace_soft_light_buffer_128_comp.h"
#include "spirv/trace_soft_light_buffer_16_comp.h"
#include "spirv/trace_soft_light_buffer_32_comp.h"
#include "spirv/trace_soft_light_buffer_4_comp.h"
#include "spirv/trace_soft_light_buffer_64_comp.h"
#include "spirv/trace_soft_light_buffer_8_comp.h"

namespace gnomon::gpu {

std::optional<TraceShader> light_buffer_shader(uint32_t lanes) {
  switch (lanes) {
    case 4: return TraceShader{trace_light_buffer_4_comp, lanes};
    case 8: return TraceShader{trace_light_buffer_8_comp, lanes};
    case 16: return TraceShader{trace_light_buffer_16_comp, lanes};
    case 32: return TraceShader{trace_light_buffer_32_comp, lanes};
    case 64: return TraceShader{trace_light_buffer_64_comp, lanes};
    case 128: return TraceShader{trace_light_buffer_128_comp, lanes, 2};
    default: return std::nullopt;
  }
}

std::optional<TraceShader> light_buffer_shader(const SubgroupFeatures& subgroups) {
  if (!subgroups.ballots_and_votes) return std::nullopt;
  return light_buffer_shader(std::clamp(16u, subgroups.least, subgroups.most));
}

std::optional<TraceShader> light_buffer_soft_shader(uint32_t lanes) {
  switch (lanes) {
    case 4: return TraceShader{trace_soft_light_buffer_4_comp, lanes};
    case 8: return TraceShader{trace_soft_light_buffer_8_comp, lanes};
    case 16: return TraceShader{trace_soft_light_buffer_16_comp, lanes};
    case 32: return TraceShader{trace_soft_light_buffer_32_comp, lanes};
    case 64: return TraceShader{trace_soft_light_buffer_64_comp, lanes};
    case 128: return TraceShader{trace_soft_light_buffer_128_comp, lanes, 2};
    default: return std::nullopt;
  }
}

}  // namespace gnomon::gpu
