#version 460
#extension GL_GOOGLE_include_directive : require
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

shared uint farthest;  // bits of a float that is not negative

void main() {
  uint i = gl_LocalInvocationIndex;
  if (i == 0u) farthest = floatBitsToUint(1.0);
  barrier();
  uvec2 pixel = gl_WorkGroupID.xy * 8u + uvec2(i % 8u, i / 8u);
  uint tile = gl_WorkGroupID.y * frame.tiles_x + gl_WorkGroupID.x;
  uint depth = floatBitsToUint(1.0);
  if (pixel.x < frame.width && pixel.y < frame.height) depth = unpackUint2x32(push.visibility.at[place_of(pixel)]).y;
  depth = subgroupMin(depth);
  if (subgroupElect()) atomicMin(farthest, depth);
  barrier();
  if (i == 0u) push.tiles.at[tile] = farthest;
}
