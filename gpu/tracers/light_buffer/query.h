// The query in C++, step by step what light_buffer.glsl does: for tests and statistics.
#pragma once

#include "gpu/exact_cpp.h"
#include "gpu/tracers/light_buffer/light_buffer.h"
#include "scenes/world_mesh.h"

namespace gnomon::gpu::light_buffer {

enum class End : uint8_t { near_plane, cover_plane, list };

struct Answer {
  bool lit = true;
  End end = End::near_plane;
  uint32_t tested = 0;  // triangles
};

// Precondition: segment.traced, by exact::shadow_segment. Every listed triangle blocks, alpha tests are not asked.
Answer query(const LightBuffer& buffer, const LightView& light, const scenes::WorldMesh& mesh,
             const exact::ShadowSegment& segment);

}  // namespace gnomon::gpu::light_buffer
