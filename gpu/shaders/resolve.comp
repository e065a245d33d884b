#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

// Converts a picture that was rasterised in compute to triangle ids, as the G-buffer pass of the graphics pipeline
// writes them.
layout(local_size_x = 64) in;

#include "raster.glsl"
layout(set = 0, binding = 1, r32ui) uniform writeonly uimage2D triangle_ids;
layout(push_constant, scalar) uniform Push { Visibility visibility; } push;

void main() {
  uint i = gl_LocalInvocationIndex;
  for (uint first = gl_WorkGroupID.x * kTilesAtATime; first < frame.tile_count;
       first += gl_NumWorkGroups.x * kTilesAtATime) {
    uvec2 halves[kTilesAtATime];
    [[unroll]] for (uint t = 0u; t < kTilesAtATime; ++t)
      halves[t] = first + t < frame.tile_count ? unpackUint2x32(push.visibility.at[(first + t) * 64u + i]) : uvec2(0u);
    [[unroll]] for (uint t = 0u; t < kTilesAtATime; ++t) {
      uvec2 pixel = pixel_in(first + t, i);
      if (is_in_picture(pixel))
        imageStore(triangle_ids, ivec2(pixel), uvec4(halves[t].y != 0u ? ~halves[t].x + 1u : 0u));
    }
  }
}
