#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) flat in uint triangle;
layout(location = 1) in vec2 surface_uv;
layout(location = 0) out uint triangle_id;

void main() {
  if (!passes_alpha_test(triangle, surface_uv)) discard;
  triangle_id = triangle + 1u;
}
