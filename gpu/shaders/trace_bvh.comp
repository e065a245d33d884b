#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_scalar_block_layout : require

struct Hierarchy {
  uvec2 nodes;
  uvec2 triangles;
  uint node_count;
  uint first_triangle;  // 0
};
#define TRACER_PUSH Hierarchy scene;
#include "trace.glsl"
#include "tracers/bvh.glsl"

bool occluded(vec3 origin, vec3 direction) { return meets(push.scene, origin, direction); }
