#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

// Traces the sample points of area lights in the hierarchies of the moving and of the resting geometry.
#include "hierarchy.glsl"
// Whether to look where the points are before they are tested: on vector units, where a test takes as many steps as a
// lane needs, and not on GPUs.
layout(constant_id = 0) const bool kLooksAtPoints = true;
#define TRACER_PUSH Hierarchy still; Hierarchy moving;
#include "trace_soft.glsl"
#include "tracers/bvh_bundle.glsl"

uint seen_samples(SoftLight light, SurfacePoint surface, vec3 origin, uint first_point) {
  Bundle bundle = Bundle(origin, frame.lights[light.light].position - origin, light.radius, first_point);
  uint open = facing_points(bundle, surface.normal);
  open = open_behind(Tree(push.moving, true), bundle, open);
  return uint(bitCount(open_behind(Tree(push.still, false), bundle, open)));
}
