#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv;
layout(location = 0) flat out uint first_triangle;
layout(location = 1) out vec2 surface_uv;

void main() {
  // Relative to the camera first: large world coordinates cancel exactly.
  gl_Position = frame.camera_to_clip * vec4(position - frame.camera, 1.0);
  first_triangle = gl_InstanceIndex;
  surface_uv = uv;
}
