#version 460
#extension GL_GOOGLE_include_directive : require

// Draws the large triangles that are not divided: several workgroups share the 64x64 tiles of each. Each invocation first
// tests whether an 8x8 block of a tile may show the triangle, then draws one pixel of each such block.
layout(local_size_x = 64) in;

#include "raster.glsl"
#include "occluded.glsl"

layout(push_constant, scalar) uniform Push {
  Visibility visibility;
  LargeList large;
  DepthTiles depth_tiles;
} push;

const int kTileSide = 64;

shared uint blocks[2];  // a bit for each block that may show the triangle

int64_t value_at(Edge e, ivec2 pixel) { return e.at_corner + int64_t(e.dx) * pixel.x + int64_t(e.dy) * pixel.y; }

int64_t most_in(Edge e, Pixels p) {
  return value_at(e, ivec2(e.dx > 0 ? p.last.x : p.first.x, e.dy > 0 ? p.last.y : p.first.y));
}

bool may_show(Prepared t, ivec2 corner) {
  Pixels block = Pixels(max(corner, t.bounds.first), min(corner + 7, t.bounds.last));
  if (none(block)) return false;
  int64_t reaches = 0l;
  for (uint k = 0u; k < 4u; ++k) reaches |= most_in(t.edges[k], block);
  uint tile = uint(corner.y) / 8u * frame.tiles_x + uint(corner.x) / 8u;
  return reaches >= 0l && !hidden(push.depth_tiles, tile, t.plane, block);
}

bool holds(Prepared t, ivec2 pixel) {
  int64_t inside = 0l;
  for (uint k = 0u; k < 4u; ++k) inside |= value_at(t.edges[k], pixel);
  return inside >= 0l && all(greaterThanEqual(pixel, t.bounds.first)) && all(lessThanEqual(pixel, t.bounds.last));
}

void draw_tile(Prepared t, Corners corners, ivec2 tile) {
  uint i = gl_LocalInvocationIndex;
  bool shows = may_show(t, tile + ivec2(i % 8u, i / 8u) * 8);
  barrier();  // all invocations have drawn the previous tile
  if (i < 2u) blocks[i] = 0u;
  barrier();
  if (shows) atomicOr(blocks[i / 32u], 1u << (i % 32u));
  barrier();
  for (uint half_tile = 0u; half_tile < 2u; ++half_tile)
    for (uint left = blocks[half_tile]; left != 0u; left &= left - 1u) {
      uint b = half_tile * 32u + uint(findLSB(left));
      ivec2 pixel = tile + ivec2(b % 8u, b / 8u) * 8 + ivec2(i % 8u, i / 8u);
      if (holds(t, pixel)) plot(push.visibility, t.triangle, corners, t.plane, uvec2(pixel));
    }
}

void draw_stripe(uint marked, int stripe) {
  Corners corners = corners_of(marked & kNumber);
  Outline o = outline_of(corners, (marked & kDoubleSided) != 0u);
  Prepared t = prepared_of(marked, corners, o, pixels_of(o));
  ivec2 first = t.bounds.first / kTileSide, tiles = t.bounds.last / kTileSide - first + 1;
  for (int tile = stripe; tile < tiles.x * tiles.y; tile += int(kStripes))
    draw_tile(t, corners, (first + ivec2(tile % tiles.x, tile / tiles.x)) * kTileSide);
}

void main() {
  uint stripes = push.large.count * kStripes;
  for (uint s = gl_WorkGroupID.x; s < stripes; s += gl_NumWorkGroups.x)
    draw_stripe(push.large.at[s / kStripes], int(s % kStripes));
}
