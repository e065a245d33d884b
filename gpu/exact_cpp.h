// gpu/shaders/exact.glsl as C++, for tests and CPU-side builders: the same arithmetic as in the shaders.
//
// Compile users with -ffp-contract=off, or products and sums may fuse and differ from the shader's in the last bit.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

namespace gnomon::gpu::exact {

using glm::abs;
using glm::max;
using glm::min;
using glm::sqrt;
using glm::vec3;
using uint = uint32_t;

#define EXACT
#define EXACT_FN inline
#include "gpu/shaders/exact.glsl"
#undef EXACT
#undef EXACT_FN

}  // namespace gnomon::gpu::exact
