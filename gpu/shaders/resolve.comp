#version 460
#extension GL_GOOGLE_include_directive : require

// Converts a picture that was rasterised in compute to triangle ids, as the G-buffer pass of the graphics pipeline
// writes them.
layout(local_size_x = 64) in;

#include "raster.glsl"
layout(set = 0, binding = 1, r32ui) uniform writeonly uimage2D triangle_ids;
layout(push_constant, scalar) uniform Push { Visibility visibility; } push;

void main() {
  uvec2 pixel = gl_WorkGroupID.xy * 8u + uvec2(gl_LocalInvocationIndex % 8u, gl_LocalInvocationIndex / 8u);
  if (pixel.x >= frame.width || pixel.y >= frame.height) return;
  uvec2 halves = unpackUint2x32(push.visibility.at[place_of(pixel)]);
  imageStore(triangle_ids, ivec2(pixel), uvec4(halves.y != 0u ? ~halves.x + 1u : 0u));
}
