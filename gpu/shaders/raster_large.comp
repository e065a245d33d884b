#version 460
#extension GL_GOOGLE_include_directive : require

// Draws the triangles that are too large for one invocation: a workgroup draws one tile of one triangle at a time. Each
// invocation first tests whether an 8x8 block of the tile may show the triangle, then draws one pixel of each such
// block. A triangle that fills a block hides what lies behind it there from all that is drawn later.
layout(local_size_x = 64) in;

#include "raster.glsl"
// For each 8x8 block the bits of a depth, not negative, that is at most that of each of its pixels.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer DepthTiles { uint at[]; };

layout(push_constant, scalar) uniform Push {
  Visibility visibility;
  LargeList large;
  DepthTiles depth_tiles;
} push;

// Exceeds the relative rounding of a plane's depths within a block.
const float kDepthSlack = 1e-5;

uint depth_tile(Pixels block) { return uint(block.first.y) / 8u * frame.tiles_x + uint(block.first.x) / 8u; }

bool hidden(Plane plane, Pixels block) {
  vec2 nearest = vec2(plane.dx > 0.0 ? block.last.x : block.first.x, plane.dy > 0.0 ? block.last.y : block.first.y);
  return uintBitsToFloat(push.depth_tiles.at[depth_tile(block)]) > depth_at(plane, nearest) * (1.0 + kDepthSlack);
}

// Precondition: the triangle fills the block, which is one of the picture's with all of its pixels.
void hide_behind(Plane plane, Pixels block) {
  vec2 farthest = vec2(plane.dx > 0.0 ? block.first.x : block.last.x, plane.dy > 0.0 ? block.first.y : block.last.y);
  float depth = depth_at(plane, farthest) * (1.0 - kDepthSlack);
  atomicMax(push.depth_tiles.at[depth_tile(block)], floatBitsToUint(depth));
}

shared uint found;

// The triangle of the list that the tile belongs to: the last one whose first tile is not after it. Each step looks at 64
// places at once, as each step waits for memory.
uint triangle_with(uint tile, uint count) {
  uint low = 0u;
  for (uint left = count; left > 1u;) {
    uint apart = (left + 63u) / 64u, place = low + apart * gl_LocalInvocationIndex;
    barrier();  // all invocations have taken what the step before found
    if (gl_LocalInvocationIndex == 0u) found = low;
    barrier();
    if (place > low && place < low + left && push.large.at[place].first_tile <= tile) atomicMax(found, place);
    barrier();
    left = min(apart, low + left - found);
    low = found;
  }
  return low;
}

shared uint blocks[2], filled[2];  // a bit for each block that may show the triangle; for each that the triangle fills

// An edge from a tile's first pixel on.
struct TileEdge {
  int at_corner, dx, dy;
};
const int64_t kFarOutside = int64_t(1) << 30;  // more than an edge that is not long changes within a tile

TileEdge in_tile(Edge e, ivec2 tile) {
  int64_t at_corner = e.at_corner + int64_t(e.dx) * tile.x + int64_t(e.dy) * tile.y;
  return TileEdge(int(clamp(at_corner, -kFarOutside, kFarOutside)), e.dx, e.dy);
}

int value_at(TileEdge e, ivec2 offset) { return e.at_corner + e.dx * offset.x + e.dy * offset.y; }

// The greatest value of the edge in the rectangle, which is relative to the tile, and the least.
int most_in(TileEdge e, Pixels p) {
  return value_at(e, ivec2(e.dx > 0 ? p.last.x : p.first.x, e.dy > 0 ? p.last.y : p.first.y));
}
int least_in(TileEdge e, Pixels p) {
  return value_at(e, ivec2(e.dx > 0 ? p.first.x : p.last.x, e.dy > 0 ? p.first.y : p.last.y));
}

// The test of a long outline, of which there are few: those that come near the camera.
bool holds(Prepared t, ivec2 pixel) {
  int64_t inside = 0l;
  for (uint k = 0u; k < 4u; ++k) {
    Edge e = t.edges[k];
    inside |= e.at_corner + int64_t(e.dx) * pixel.x + int64_t(e.dy) * pixel.y;
  }
  return inside >= 0l;
}

void draw_tile(uint marked, Prepared t, uint number) {
  uint i = gl_LocalInvocationIndex;
  int across = tiles_of(t.bounds).x;
  ivec2 tile =
      (t.bounds.first / int(kTileSide) + ivec2(int(number) % across, int(number) / across)) * int(kTileSide);
  TileEdge edges[4];
  for (uint k = 0u; k < 4u; ++k) edges[k] = in_tile(t.edges[k], tile);
  bool long_edges = t.is_long != 0u;
  Corners corners;  // only a masked triangle needs them
  if ((marked & kMasked) != 0u) corners = corners_of(marked & kNumber);

  ivec2 corner = tile + ivec2(i % 8u, i / 8u) * 8;
  Pixels block = Pixels(max(corner, t.bounds.first), min(corner + 7, t.bounds.last));
  Pixels offsets = Pixels(block.first - tile, block.last - tile);
  bool reaches = (most_in(edges[0], offsets) | most_in(edges[1], offsets) | most_in(edges[2], offsets) |
                  most_in(edges[3], offsets)) >= 0;
  bool shows = !none(block) && (reaches || long_edges) && !hidden(t.plane, block);
  barrier();  // all invocations have drawn the previous tile
  if (i < 2u) blocks[i] = filled[i] = 0u;
  barrier();
  if (shows) {
    atomicOr(blocks[i / 32u], 1u << (i % 32u));
    bool fills = (least_in(edges[0], offsets) | least_in(edges[1], offsets) | least_in(edges[2], offsets) |
                  least_in(edges[3], offsets)) >= 0;
    bool whole = block.first == corner && block.last == min(corner + 7, ivec2(frame.width, frame.height) - 1);
    if (fills && whole && !long_edges) {
      atomicOr(filled[i / 32u], 1u << (i % 32u));
      if ((marked & kMasked) == 0u) hide_behind(t.plane, block);
    }
  }
  barrier();
  for (uint half_tile = 0u; half_tile < 2u; ++half_tile)
    for (uint left = blocks[half_tile]; left != 0u; left &= left - 1u) {
      uint bit = uint(findLSB(left)), b = half_tile * 32u + bit;
      ivec2 offset = ivec2(b % 8u, b / 8u) * 8 + ivec2(i % 8u, i / 8u), pixel = tile + offset;
      bool inside = all(lessThan(pixel, ivec2(frame.width, frame.height)));
      if ((filled[half_tile] >> bit & 1u) == 0u)
        inside = all(greaterThanEqual(pixel, t.bounds.first)) && all(lessThanEqual(pixel, t.bounds.last)) &&
                 (long_edges ? holds(t, pixel)
                             : (value_at(edges[0], offset) | value_at(edges[1], offset) | value_at(edges[2], offset) |
                                value_at(edges[3], offset)) >= 0);
      if (inside) plot(push.visibility, marked, corners, t.plane, uvec2(pixel));
    }
}

void main() {
  uvec2 count = unpackUint2x32(push.large.count);
  for (uint tile = gl_WorkGroupID.x; tile < count.x; tile += gl_NumWorkGroups.x) {
    uint entry = triangle_with(tile, count.y);
    Large large = push.large.at[entry];
    Prepared t;
    if (entry < kMostPrepared)
      t = push.large.prepared[entry];
    else
      t = prepared_of(large.triangle);
    draw_tile(large.triangle, t, tile - large.first_tile);
  }
}
