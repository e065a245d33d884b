#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// Traces moving lights and moving geometry, after the trace pass: moving lights are traced in the hierarchy of the
// resting geometry, and every pair that is still lit in the hierarchy of the moving geometry.
struct Hierarchy {
  uvec2 nodes;
  uvec2 triangles;
  uint node_count;
  uint first_triangle;  // of the scene's numbers
};
#define TRACER_PUSH Hierarchy still; Hierarchy moving; uint moving_lights[8];
#define TRACE_COMBINES
#include "trace.glsl"
#include "tracers/bvh.glsl"

bool light_moves(uint light) { return ((push.moving_lights[light / 32u] >> (light % 32u)) & 1u) != 0u; }

uvec4 answer(SurfacePoint surface, uint light, uint word, uvec2 my_bit) {
  bool moves = light_moves(light);
  ShadowSegment segment = shadow_segment(frame.camera, surface, frame.lights[light]);
  bool asked = moves ? segment.traced : any(notEqual(push.masks.at[word] & my_bit, uvec2(0u)));
  if (!asked) return uvec4(0u);
  bool hidden = meets(push.moving, segment.origin, segment.direction) ||
                (moves && meets(push.still, segment.origin, segment.direction));
  return uvec4(hidden ? uvec2(0u) : my_bit, my_bit);
}

void store(uint light, uint word, uvec4 halves) {
  push.masks.at[word] = halves.xy;
  if (light_moves(light)) push.valid_bits.at[word] = halves.zw;
}
