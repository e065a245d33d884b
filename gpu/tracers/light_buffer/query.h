// The query of shaders/tracers/light_buffer.glsl in C++, step by step, for tests and statistics.
#pragma once

#include <span>

#include "gpu/exact_cpp.h"
#include "gpu/tracers/light_buffer/light_buffer.h"
#include "scenes/world_mesh.h"

namespace gnomon::gpu::light_buffer {

enum class End : uint8_t { near_plane, cover_plane, list };

struct Answer {
  bool lit = true;
  End end = End::near_plane;
  uint32_t steps = 0;    // entries of the list that were looked at
  uint32_t tested = 0;   // triangles
  uint32_t blocker = 0;  // the last of them, of what a list leaves dark
};

// Treats every triangle as opaque, as it makes no alpha tests. Precondition: exact::shadow_segment made the segment,
// and segment.traced.
Answer query(const LightBuffer& buffer, const LightView& light, const scenes::WorldMesh& mesh,
             const exact::ShadowSegment& segment);

struct AreaAnswer {
  uint32_t seen = 0;  // of the points
  End end = End::near_plane;
  uint32_t steps = 0;   // entries of the list that were looked at
  uint32_t tested = 0;  // triangles
};

// As query, for at most 32 sample points of an area light. `surface`: of a pair whose segment to the light's middle,
// from `origin`, is traced.
AreaAnswer query_area(const LightBuffer& buffer, const LightView& light, const scenes::WorldMesh& mesh,
                      const exact::SurfacePoint& surface, const glm::vec3& origin,
                      std::span<const glm::vec3> points);

}  // namespace gnomon::gpu::light_buffer
