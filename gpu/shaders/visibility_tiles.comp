#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_KHR_shader_subgroup_arithmetic : require

// Writes the farthest depth of each 8x8 tile of a picture that was rasterised in compute; 0 if some pixel of the tile
// shows no surface.
layout(local_size_x = 64) in;

#include "raster.glsl"
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer DepthTiles { uint at[]; };
layout(push_constant, scalar) uniform Push {
  Visibility visibility;
  DepthTiles tiles;
} push;

shared uint farthest[kTilesAtATime];  // bits of floats that are not negative

void main() {
  uint i = gl_LocalInvocationIndex;
  for (uint first = gl_WorkGroupID.x * kTilesAtATime; first < frame.tile_count;
       first += gl_NumWorkGroups.x * kTilesAtATime) {
    barrier();  // the tiles before are written
    if (i < kTilesAtATime) farthest[i] = floatBitsToUint(1.0);
    uint depth[kTilesAtATime];
    [[unroll]] for (uint t = 0u; t < kTilesAtATime; ++t)
      depth[t] = is_in_picture(pixel_in(first + t, i)) ? unpackUint2x32(push.visibility.at[(first + t) * 64u + i]).y
                                                       : floatBitsToUint(1.0);
    barrier();
    [[unroll]] for (uint t = 0u; t < kTilesAtATime; ++t) {
      uint least = subgroupMin(depth[t]);
      if (subgroupElect()) atomicMin(farthest[t], least);
    }
    barrier();
    if (i < kTilesAtATime && first + i < frame.tile_count) push.tiles.at[first + i] = farthest[i];
  }
}
