// Light buffers as the shader reads them. gpu/tracers/light_buffer/light_buffer.h defines them and explains why the
// answers are exact; query.cpp is the same query in C++.
#include "texels.glsl"
#include "tracers/alpha.glsl"

const uint kTopLevel = 8u;
const uint kIndexBits = 16u;
const uint kCountBits = 24u;
const uint kDepthBits = 3u;

struct LightView {
  vec3 reference;
  uint directional;
  vec3 u_axis;
  float u_offset;
  vec3 v_axis;
  float v_offset;
  vec3 depth_axis;
  uint cells;
  vec3 direction;  // directional: of every segment
  uint reserved;
};
// A leaf: what decides most of its pixels, and the rest.
struct NearSide {
  vec3 near_plane;
  uint first;
};
struct FarSide {
  vec3 cover_plane;
  uint count;
};
// What a walk looks at of an entry before its triangle.
struct EntryBounds {
  uint depth_and_low;
  uint high_and_strip;
};
struct ListEntry {
  EntryBounds bounds;
  uint triangle;
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LightViews { LightView at[]; };

#ifdef BY_TEXELS

layout(set = LIGHT_BUFFER_SET, binding = 0, r32ui) uniform readonly uimageBuffer light_grid;
layout(set = LIGHT_BUFFER_SET, binding = 1, rgba32ui) uniform readonly uimageBuffer light_leaves;
layout(set = LIGHT_BUFFER_SET, binding = 2, rgba32ui) uniform readonly uimageBuffer light_bounds;  // of two entries
layout(set = LIGHT_BUFFER_SET, binding = 3, r32ui) uniform readonly uimageBuffer light_triangles;

uint grid_at(uint n) { return imageLoad(light_grid, int(n)).x; }

NearSide near_side(uint leaf) {
  uvec4 side = imageLoad(light_leaves, int(2u * leaf));
  return NearSide(uintBitsToFloat(side.xyz), side.w);
}
FarSide far_side(uint leaf) {
  uvec4 side = imageLoad(light_leaves, int(2u * leaf + 1u));
  return FarSide(uintBitsToFloat(side.xyz), side.w);
}

EntryBounds bounds_at(uint n) {
  uvec4 two = imageLoad(light_bounds, int(n >> 1));
  return (n & 1u) != 0u ? EntryBounds(two.z, two.w) : EntryBounds(two.x, two.y);
}
uint triangle_of(uint n) { return imageLoad(light_triangles, int(n)).x; }

TriangleCorners corners_of(uint triangle) { return corners_at_rest(triangle); }

#else

struct LeafSides {
  NearSide near;
  FarSide far;
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Leaves { LeafSides at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Entries { ListEntry at[]; };
// As a walk reads them: in one place.
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Corners { TriangleCorners at[]; };

uint grid_at(uint n) { return Uints(push.grid).at[n]; }
NearSide near_side(uint leaf) { return Leaves(push.leaves).at[leaf].near; }
FarSide far_side(uint leaf) { return Leaves(push.leaves).at[leaf].far; }
ListEntry entry_at(uint n) { return Entries(push.entries).at[n]; }
EntryBounds bounds_at(uint n) { return Entries(push.entries).at[n].bounds; }
uint triangle_of(uint n) { return Entries(push.entries).at[n].triangle; }
TriangleCorners corners_of(uint triangle) { return Corners(push.corners).at[triangle]; }

#endif

// Converts to int first, because not all vector units can convert to uint.
uvec2 to_fixed(vec2 p) { return uvec2(ivec2(clamp(p, vec2(0.0), vec2(65535.0)))); }

// A place on a light's faces, in fixed point, and the depth of the point.
struct Place {
  uint face;
  uvec2 at;
  float depth;
};

Place cube_place(vec3 rel) {
  Place place;
  vec3 size = abs(rel);
  bool x = size.x >= size.y && size.x >= size.z;
  bool y = !x && size.y >= size.z;
  place.depth = x ? size.x : y ? size.y : size.z;
  vec2 across = x ? rel.yz : y ? rel.zx : rel.xy;
  bool negative = (x ? rel.x : y ? rel.y : rel.z) < 0.0;
  place.face = (x ? 0u : y ? 2u : 4u) + (negative ? 1u : 0u);
  place.at = to_fixed(across * (32768.0 / place.depth) + 32768.0);
  return place;
}

Place flat_place(LightView view, vec3 rel) {
  return Place(0u, to_fixed(vec2(dot(view.u_axis, rel) + view.u_offset, dot(view.v_axis, rel) + view.v_offset)),
               dot(view.depth_axis, rel));
}

// `rel`: a point relative to the light's reference.
Place place_of(LightView view, vec3 rel) {
  if (view.directional != 0u) return flat_place(view, rel);
  return cube_place(rel);
}

const uint kCellShift = kIndexBits - kTopLevel;

uint cell_at(LightView view, Place place) {
  uvec2 cell = place.at >> kCellShift;
  return grid_at(view.cells + (place.face << (2u * kTopLevel)) + (cell.y << kTopLevel) + cell.x);
}

// The leaf within the cell.
uint leaf_at(uint cell, Place place) {
  uint bits = cell & ((1u << kDepthBits) - 1u);
  uvec2 sub = (place.at >> (kCellShift - bits)) & ((1u << bits) - 1u);
  return grid_at((cell >> kDepthBits) + (sub.y << bits) + sub.x);
}

// The place in 256ths of the leaf's side, x in the low half. `count`: Leaf::count, which contains the level.
uint place_in_leaf(uvec2 at, uint count) {
  uvec2 place = ((at << (count >> kCountBits)) & ((1u << kIndexBits) - 1u)) >> (kIndexBits - 8u);
  return place.x | place.y << 16;
}

bool in_front(EntryBounds entry, float depth) { return depth * uintBitsToFloat(entry.depth_and_low >> 1) < 1.0; }

// Whether the place lies in the entry's box and strip.
bool holds(EntryBounds entry, uint place) {
  uint x = place & 255u, y = place >> 16, low = entry.depth_and_low, high = entry.high_and_strip;
  bool in_box = (x >> 3) >= (low & 31u) && (y >> 3) >= ((low >> 5) & 31u) && (x >> 3) <= (high & 31u) &&
                (y >> 3) <= ((high >> 5) & 31u);
  int strip = int(high);
  int across_x = 32 - ((strip >> 10) & 63), across_y = 32 - abs(across_x);
  int across = (across_x * int(x) + across_y * int(y)) >> 6;
  return in_box && across >= bitfieldExtract(strip, 16, 8) && across <= strip >> 24;
}
