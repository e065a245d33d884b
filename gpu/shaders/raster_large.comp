#version 460
#extension GL_GOOGLE_include_directive : require

// Draws the triangles that are too large for one invocation: a workgroup draws one tile of one triangle at a time. Each
// invocation first tests whether an 8x8 block of the tile may show the triangle, then draws one pixel of each such
// block.
layout(local_size_x = 64) in;

#include "raster.glsl"
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DepthTiles { float at[]; };

layout(push_constant, scalar) uniform Push {
  Visibility visibility;
  LargeList large;
  uvec2 depth_tiles;  // address of DepthTiles; 0: nothing hides anything yet
} push;

// Exceeds the relative rounding of a plane's depths within a block.
const float kDepthSlack = 1e-5;

struct Edge {
  int64_t at_corner;  // value at the centre of the picture's first pixel; inside where values are not negative
  int64_t dx, dy;     // to the next pixel
};

Edge edge(ivec2 from, ivec2 to) {
  i64vec2 along = i64vec2(to) - i64vec2(from), off = i64vec2(kSubpixels / 2) - i64vec2(from);
  int64_t above_or_left = along.y < 0l || (along.y == 0l && along.x >= 0l) ? 0l : -1l;
  return Edge(along.x * off.y - along.y * off.x + above_or_left, -along.y * kSubpixels, along.x * kSubpixels);
}

int64_t value_at(Edge e, ivec2 pixel) { return e.at_corner + e.dx * pixel.x + e.dy * pixel.y; }

// The greatest value of the edge in the rectangle.
int64_t most_in(Edge e, Pixels p) {
  return value_at(e, ivec2(e.dx > 0l ? p.last.x : p.first.x, e.dy > 0l ? p.last.y : p.first.y));
}

bool hidden(Plane plane, Pixels block) {
  if (push.depth_tiles == uvec2(0)) return false;
  vec2 nearest = vec2(plane.dx > 0.0 ? block.last.x : block.first.x, plane.dy > 0.0 ? block.last.y : block.first.y);
  uint tile = uint(block.first.y) / 8u * frame.tiles_x + uint(block.first.x) / 8u;
  return DepthTiles(push.depth_tiles).at[tile] > depth_at(plane, nearest) * (1.0 + kDepthSlack);
}

// The triangle of the list that the tile belongs to: the last one whose first tile is not after it.
uint triangle_with(uint tile, uint count) {
  uint low = 0u, high = count;
  while (high - low > 1u) {
    uint middle = (low + high) / 2u;
    if (push.large.at[middle].first_tile <= tile)
      low = middle;
    else
      high = middle;
  }
  return low;
}

shared uint blocks[2], filled[2];  // a bit for each block that may show the triangle; for each that the triangle fills

// The least value of the edge in the rectangle.
int64_t least_in(Edge e, Pixels p) {
  return value_at(e, ivec2(e.dx > 0l ? p.first.x : p.last.x, e.dy > 0l ? p.first.y : p.last.y));
}

void draw_tile(Large large, uint number) {
  uint i = gl_LocalInvocationIndex;
  Corners corners = corners_of(large.triangle & kNumber);
  Outline o = outline_of(corners, (large.triangle & kDoubleSided) != 0u);
  Pixels bounds = pixels_of(o);
  Plane plane = plane_of(corners, o);
  Edge e0 = edge(o.at[0], o.at[1]), e1 = edge(o.at[1], o.at[2]), e2 = edge(o.at[2], o.at[3]),
       e3 = edge(o.at[3], o.at[0]);
  int across = tiles_of(bounds).x;
  ivec2 tile = (bounds.first / int(kTileSide) + ivec2(int(number) % across, int(number) / across)) * int(kTileSide);

  ivec2 corner = tile + ivec2(i % 8u, i / 8u) * 8;
  Pixels block = Pixels(max(corner, bounds.first), min(corner + 7, bounds.last));
  bool shows = !none(block) && most_in(e0, block) >= 0l && most_in(e1, block) >= 0l && most_in(e2, block) >= 0l &&
               most_in(e3, block) >= 0l && !hidden(plane, block);
  barrier();  // all invocations have drawn the previous tile
  if (i < 2u) blocks[i] = filled[i] = 0u;
  barrier();
  if (shows) {
    bool fills = (least_in(e0, block) | least_in(e1, block) | least_in(e2, block) | least_in(e3, block)) >= 0l;
    atomicOr(blocks[i / 32u], 1u << (i % 32u));
    if (fills) atomicOr(filled[i / 32u], 1u << (i % 32u));
  }
  barrier();
  for (uint half_tile = 0u; half_tile < 2u; ++half_tile)
    for (uint left = blocks[half_tile]; left != 0u; left &= left - 1u) {
      uint bit = uint(findLSB(left)), b = half_tile * 32u + bit;
      ivec2 pixel = tile + ivec2(b % 8u, b / 8u) * 8 + ivec2(i % 8u, i / 8u);
      bool inside = all(greaterThanEqual(pixel, bounds.first)) && all(lessThanEqual(pixel, bounds.last));
      if ((filled[half_tile] >> bit & 1u) == 0u)
        inside = inside &&
                 (value_at(e0, pixel) | value_at(e1, pixel) | value_at(e2, pixel) | value_at(e3, pixel)) >= 0l;
      if (inside) plot(push.visibility, large.triangle, corners, plane, uvec2(pixel));
    }
}

void main() {
  uvec2 count = unpackUint2x32(push.large.count);
  for (uint tile = gl_WorkGroupID.x; tile < count.x; tile += gl_NumWorkGroups.x) {
    Large large = push.large.at[triangle_with(tile, count.y)];
    draw_tile(large, tile - large.first_tile);
  }
}
