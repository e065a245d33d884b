#version 460
#extension GL_GOOGLE_include_directive : require
#include "frame.glsl"
#include "surface.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer Ids { uint at[]; };
layout(push_constant, scalar) uniform Push { Ids ids; } push;

void main() {
  uvec2 pixel = gl_WorkGroupID.xy * 8u + pixel_in_tile(gl_LocalInvocationIndex);
  if (pixel.x >= frame.width || pixel.y >= frame.height) return;
  push.ids.at[pixel.y * frame.width + pixel.x] = triangle_at(pixel);
}
