#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_samplerless_texture_functions : require
#include "frame.glsl"

// Writes the farthest depth of each 8x8 tile; 0 if some pixel of the tile shows no surface.
layout(local_size_x = 64) in;
layout(set = 0, binding = 1) uniform texture2D depth;
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer DepthTiles { float at[]; };
layout(push_constant, scalar) uniform Push { DepthTiles tiles; } push;

void main() {
  uint tile = gl_GlobalInvocationID.x;
  if (tile >= frame.tile_count) return;
  ivec2 first = ivec2(tile % frame.tiles_x, tile / frame.tiles_x) * 8;
  ivec2 end = min(first + 8, ivec2(frame.width, frame.height));
  float farthest = 1.0;
  for (int y = first.y; y < end.y; ++y)
    for (int x = first.x; x < end.x; ++x) farthest = min(farthest, texelFetch(depth, ivec2(x, y), 0).x);
  push.tiles.at[tile] = farthest;
}
