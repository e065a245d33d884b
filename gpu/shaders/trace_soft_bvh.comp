#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// Traces the sample points of area lights one by one, in the hierarchies of the resting and of the moving geometry.
struct Hierarchy {
  uvec2 nodes;
  uvec2 triangles;
  uint node_count;
  uint first_triangle;  // of the scene's numbers
};
#define TRACER_PUSH Hierarchy still; Hierarchy moving;
#include "trace_soft.glsl"
#include "tracers/bvh.glsl"

uint seen_samples(SoftLight light, SurfacePoint surface, vec3 origin, uint first_point) {
  uint seen = 0u;
  for (uint i = 0u; i < push.soft.samples; ++i) {
    ShadowSegment segment = sample_segment(origin, surface.normal, push.soft.points[first_point + i]);
    if (segment.traced && !meets(push.moving, origin, segment.direction) &&
        !meets(push.still, origin, segment.direction))
      ++seen;
  }
  return seen;
}
