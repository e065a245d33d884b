// Rasterisation in compute: the outline of a triangle in fixed-point integers, its depth, and the picture of both.
//
// Edge functions (Pineda, "A Parallel Algorithm for Polygon Rasterization", 1988) decide coverage as in graphics
// hardware: corners are rounded to a grid of 1/256 pixel, edge values are integers, and a pixel whose centre lies on an
// edge belongs to one of the two triangles by the top-left rule, so that neighbours share no pixel and leave none out.
// Depth comes from the triangle's plane, and is clamped to the depths of its corners. A pixel is one 64-bit value of
// depth and triangle, updated by an atomic maximum (as in Karis, Stubbe and Wihlidal, "A Deep Dive into Nanite
// Virtualized Geometry", SIGGRAPH 2021 course): it keeps the greatest (nearest) depth, and of equally near triangles
// the first, which is the result of drawing in order.
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#include "frame.glsl"

// For each pixel, tile by tile and row by row within a tile: the bits of its depth in the upper half, those of
// ~triangle in the lower; 0 if it shows no triangle.
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer Visibility { uint64_t at[]; };

uint place_of(uvec2 pixel) {
  uvec2 tile = pixel / 8u, in_tile = pixel % 8u;
  return ((tile.y * frame.tiles_x + tile.x) * 8u + in_tile.y) * 8u + in_tile.x;
}

// Tiles of which passes over the whole picture read a pixel each before they go on, as they mostly wait for memory.
// Tiles are numbered row by row.
const uint kTilesAtATime = 8;
uvec2 pixel_in(uint tile, uint place) {
  return uvec2(tile % frame.tiles_x, tile / frame.tiles_x) * 8u + uvec2(place % 8u, place / 8u);
}
// False also for pixels of tiles behind the last.
bool is_in_picture(uvec2 pixel) { return pixel.x < frame.width && pixel.y < frame.height; }

const int kSubpixels = 256;
// Grid points. Corners are clamped to this distance, so that edge values fit into 64 bits.
const float kFarthest = 536870912.0;

// Marks beside the triangle's number, in lists of triangles.
const uint kDoubleSided = 0x80000000u;
const uint kMasked = 0x40000000u;
const uint kNumber = 0x3fffffffu;

// A polygon in grid points, ordered so that all edge values are positive inside; a triangle has its last corner twice.
struct Outline {
  ivec2 at[4];
  float nearest, farthest;  // depth: greater is nearer
  bool shows;               // false behind the near plane, for back faces, and without area
};

// A rectangle of pixels, with both ends included.
struct Pixels {
  ivec2 first, last;
};

ivec2 to_grid(vec4 clip) {
  precise vec2 pixel = (clip.xy / clip.w * 0.5 + 0.5) * vec2(frame.width, frame.height);
  precise vec2 grid = floor(pixel * float(kSubpixels) + 0.5);
  return ivec2(clamp(grid, vec2(-kFarthest), vec2(kFarthest)));
}

// The point where an edge meets the near plane. It is computed from the end in front of the plane, so that both
// triangles of the edge agree.
vec4 at_near_plane(vec4 before, vec4 behind) {
  precise float t = (before.w - near_plane()) / (before.w - behind.w);
  precise vec4 met = before + t * (behind - before);
  met.w = near_plane();
  return met;
}

// Clips a triangle by the near plane, which leaves three or four corners.
void cut(vec4 clip[3], out ivec2 at[4]) {
  uint count = 0u;
  for (uint i = 0u; i < 3u; ++i) {
    vec4 p = clip[i], q = clip[(i + 1u) % 3u];
    bool p_shows = p.w >= near_plane(), q_shows = q.w >= near_plane();
    if (p_shows) at[count++] = to_grid(p);
    if (p_shows != q_shows) at[count++] = to_grid(at_near_plane(p_shows ? p : q, p_shows ? q : p));
  }
  if (count == 3u) at[3] = at[2];
}

int64_t doubled_area(ivec2 a, ivec2 b, ivec2 c) {
  i64vec2 ab = i64vec2(b) - i64vec2(a), ac = i64vec2(c) - i64vec2(a);
  return ab.x * ac.y - ab.y * ac.x;
}

struct Corners {
  vec3 a, b, c;  // relative to the camera, in world axes
};

Corners corners_of(uint triangle) {
  uvec3 corners = frame.triangles.at[triangle];
  return Corners(frame.positions.at[corners.x] - frame.camera, frame.positions.at[corners.y] - frame.camera,
                 frame.positions.at[corners.z] - frame.camera);
}

Outline outline_of(Corners corners, bool double_sided) {
  precise vec4 a = frame.camera_to_clip * vec4(corners.a, 1.0);
  precise vec4 b = frame.camera_to_clip * vec4(corners.b, 1.0);
  precise vec4 c = frame.camera_to_clip * vec4(corners.c, 1.0);
  float shallow = min(a.w, min(b.w, c.w)), deep = max(a.w, max(b.w, c.w));
  Outline o;
  o.shows = deep >= near_plane();
  o.nearest = shallow > near_plane() ? near_plane() / shallow : 1.0;
  o.farthest = o.shows ? near_plane() / deep : 1.0;
  o.at[0] = to_grid(a), o.at[1] = to_grid(b), o.at[2] = to_grid(c), o.at[3] = o.at[2];
  if (o.shows && shallow < near_plane()) {
    vec4 clip[3] = vec4[3](a, b, c);
    cut(clip, o.at);
  }
  int64_t area = doubled_area(o.at[0], o.at[1], o.at[2]) + doubled_area(o.at[0], o.at[2], o.at[3]);
  if (area == 0l || (area > 0l && !double_sided)) o.shows = false;  // front faces are negative, as y points down
  if (area < 0l) {
    ivec2 second = o.at[1];
    o.at[1] = o.at[3];
    o.at[3] = second;
  }
  return o;
}

// The picture's pixels whose centres are within the outline's bounding rectangle.
Pixels pixels_of(Outline o) {
  ivec2 low = min(min(o.at[0], o.at[1]), min(o.at[2], o.at[3]));
  ivec2 high = max(max(o.at[0], o.at[1]), max(o.at[2], o.at[3]));
  Pixels p;
  p.first = max((low + (kSubpixels / 2 - 1)) >> 8, ivec2(0));
  p.last = min((high - kSubpixels / 2) >> 8, ivec2(frame.width, frame.height) - 1);
  return p;
}

bool none(Pixels p) { return any(greaterThan(p.first, p.last)); }

// The depth of a triangle's plane, which is linear in pixels.
struct Plane {
  float at_corner, dx, dy;
  float nearest, farthest;
};

Plane plane_of(Corners corners, Outline o) {
  vec3 normal = cross(corners.b - corners.a, corners.c - corners.a);
  float height = dot(normal, corners.a);
  Plane plane = Plane(o.nearest, 0.0, 0.0, o.nearest, o.farthest);
  if (height != 0.0) {
    float scale = near_plane() / height;
    plane.at_corner = scale * dot(normal, frame.ray_corner + 0.5 * (frame.ray_dx + frame.ray_dy));
    plane.dx = scale * dot(normal, frame.ray_dx);
    plane.dy = scale * dot(normal, frame.ray_dy);
  }
  return plane;
}

float depth_at(Plane plane, vec2 pixel) {
  return min(max(plane.at_corner + pixel.x * plane.dx + pixel.y * plane.dy, plane.farthest), plane.nearest);
}

bool solid_at(uint triangle, Corners corners, uvec2 pixel) {
  vec3 ray = pixel_ray(pixel);
  vec3 weights = vec3(dot(cross(corners.b, corners.c), ray), dot(cross(corners.c, corners.a), ray),
                      dot(cross(corners.a, corners.b), ray));
  return passes_alpha_test(triangle, uv_at(triangle, weights / (weights.x + weights.y + weights.z)));
}

uint64_t value_of(uint triangle, float depth) { return packUint2x32(uvec2(~triangle, floatBitsToUint(depth))); }

// Writes a pixel of a triangle. `marked`: its number and marks.
void plot(Visibility visibility, uint marked, Corners corners, Plane plane, uvec2 pixel) {
  uint triangle = marked & kNumber;
  uint64_t value = value_of(triangle, depth_at(plane, vec2(pixel)));
  uint place = place_of(pixel);
  // The value that is read may be outdated, but values only grow: no triangle is lost, and most writes are avoided.
  if (visibility.at[place] >= value) return;
  if ((marked & kMasked) != 0u && !solid_at(triangle, corners, pixel)) return;
  atomicMax(visibility.at[place], value);
}

// The most workgroups of an indirect dispatch; they share the work, whatever their number.
const uint kMostGroups = 65535;

// An edge of an outline. Edge values change by multiples of kSubpixels from pixel to pixel, so that their signs are those of
// values divided by kSubpixels and rounded down, which these are.
struct Edge {
  int64_t at_corner;  // value at the centre of the picture's first pixel; inside where values are not negative
  int dx, dy;         // to the next pixel
};

Edge edge_between(ivec2 from, ivec2 to) {
  i64vec2 along = i64vec2(to) - i64vec2(from), off = i64vec2(kSubpixels / 2) - i64vec2(from);
  int64_t above_or_left = along.y < 0l || (along.y == 0l && along.x >= 0l) ? 0l : -1l;
  return Edge((along.x * off.y - along.y * off.x + above_or_left) >> 8, -int(along.y), int(along.x));
}

// What all parts of a large triangle need.
struct Prepared {
  Edge edges[4];
  Pixels bounds;
  Plane plane;
  uint triangle;  // marked
};

Prepared prepared_of(uint marked, Corners corners, Outline o, Pixels bounds) {
  Prepared t;
  for (uint k = 0u; k < 4u; ++k) t.edges[k] = edge_between(o.at[k], o.at[(k + 1u) % 4u]);
  t.bounds = bounds;
  t.plane = plane_of(corners, o);
  t.triangle = marked;
  return t;
}

// An edge's values at the pixels of an 8x8 block, from the block's first pixel on: they fit into 32 bits if the outline's
// bounding rectangle is at most kLongest wide and high. Farther from the edge they are clamped, which keeps their signs.
struct BlockEdge {
  int at_corner, dx, dy;
};
const int kLongest = 1 << 26;                  // grid points
const int64_t kFarOutside = int64_t(1) << 30;  // more than such an edge changes within a block

BlockEdge in_block(Edge e, ivec2 corner) {
  int64_t at_corner = e.at_corner + int64_t(e.dx) * corner.x + int64_t(e.dy) * corner.y;
  return BlockEdge(int(clamp(at_corner, -kFarOutside, kFarOutside)), e.dx, e.dy);
}

int value_at(BlockEdge e, ivec2 offset) { return e.at_corner + e.dx * offset.x + e.dy * offset.y; }

// Lists of what is too large for one invocation of raster_runs.comp. Most such triangles are divided into 8x8 blocks by
// divide_large.comp; raster_large.comp draws the others whole.
const uint kMostDivided = 32768;  // triangles of a list
const uint kStripes = 16;         // workgroups of raster_large.comp for a triangle
const int kBlocksOfCount = 40;    // bits: LargeList::divided counts triangles in those above
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer LargeList {
  uint groups, one, also_one;  // VkDispatchIndirectCommand of raster_large.comp
  uint count;                  // of triangles that are drawn whole
  uint dividing_groups, dividing_one, dividing_also_one;  // VkDispatchIndirectCommand of divide_large.comp
  uint reserved;
  // The numbers of divided triangles and of the blocks of their bounding rectangles. Triangles that find no room are not
  // divided: from the first one on none does, and `~refused`, if that is not 0, has the numbers before it.
  uint64_t divided, refused;
  Prepared prepared[kMostDivided];
  uint first_block[kMostDivided];  // of each divided triangle, counted through the list
  uint at[];                       // triangles that are drawn whole, marked
};

// Blocks that divided triangles may show in: the number of the picture's 8x8 tile, and above it the triangle's place in
// its list.
const int kPlaceBits = 17;
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer BlockList {
  uint groups, one, also_one;  // VkDispatchIndirectCommand of raster_blocks.comp
  uint count;
  uint at[];
};
const uint kBlocksOfGroup = 8;  // of a workgroup of raster_blocks.comp

ivec2 blocks_of(Pixels p) { return p.last / 8 - p.first / 8 + 1; }

// A run of at most 64 triangles, which a workgroup draws together.
struct Run {
  uint first;
  uint count;  // marked
};
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer RunList {
  uint groups, one, also_one;  // VkDispatchIndirectCommand
  uint count;
  Run at[];
};
