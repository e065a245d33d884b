#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_control_flow_attributes : require

// Draws the blocks of divided triangles.
layout(local_size_x = 64) in;

#include "raster.glsl"
#include "occluded.glsl"

layout(push_constant, scalar) uniform Push {
  Visibility visibility;
  LargeList large;
  BlockList blocks;
  DepthTiles depth_tiles;
} push;

const uint kPixels = 4;  // of an invocation, side by side; as many blocks are drawn at the same time

void draw(uint block, ivec2 offset) {
  uint tile = block & ((1u << kPlaceBits) - 1u), place = tile * 64u + uint(offset.y * 8 + offset.x);
  Prepared t = push.large.prepared[block >> kPlaceBits];
  // Read before it is known whether they are needed: what is waited for here is waited for at once.
  float hiding = uintBitsToFloat(push.depth_tiles.at[tile]);
  uint64_t shown[kPixels];
  [[unroll]] for (uint x = 0u; x < kPixels; ++x) shown[x] = push.visibility.at[place + x];
  ivec2 corner = ivec2(tile % frame.tiles_x, tile / frame.tiles_x) * 8, first = corner + offset;
  int values[4];
  for (uint k = 0u; k < 4u; ++k) values[k] = value_at(in_block(t.edges[k], corner), offset);
  // Rounding may twist an outline that the near plane has cut: its edges alone could hold what its rectangle does not.
  if (first.y < t.bounds.first.y || first.y > t.bounds.last.y) return;
  [[unroll]] for (uint x = 0u; x < kPixels; ++x) {
    ivec2 pixel = first + ivec2(x, 0);
    int inside = (values[0] + int(x) * t.edges[0].dx) | (values[1] + int(x) * t.edges[1].dx) |
                 (values[2] + int(x) * t.edges[2].dx) | (values[3] + int(x) * t.edges[3].dx);
    float depth = depth_at(t.plane, vec2(pixel));
    uint64_t value = value_of(t.triangle & kNumber, depth);
    if (inside < 0 || pixel.x < t.bounds.first.x || pixel.x > t.bounds.last.x ||
        hiding > depth * (1.0 + kDepthSlack) || shown[x] >= value)
      continue;
    if ((t.triangle & kMasked) != 0u &&
        !solid_at(t.triangle & kNumber, corners_of(t.triangle & kNumber), uvec2(pixel)))
      continue;
    atomicMax(push.visibility.at[place + x], value);
  }
}

void main() {
  const uint kLanes = 64u / kPixels;  // of a block
  uint count = push.blocks.count, i = gl_LocalInvocationIndex % kLanes, own = gl_LocalInvocationIndex / kLanes;
  ivec2 offset = ivec2(i * kPixels % 8u, i * kPixels / 8u);
  for (uint b = gl_WorkGroupID.x * kPixels + own; b < count; b += gl_NumWorkGroups.x * kPixels)
    draw(push.blocks.at[b], offset);
}
