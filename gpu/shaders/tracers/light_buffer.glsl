// Light buffers as the shader reads them. gpu/tracers/light_buffer/light_buffer.h defines them and explains why the
// answers are exact; query.cpp is the same query in C++.
#include "pairs.glsl"
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
struct Leaf {
  vec3 near_plane;
  uint first;
  vec3 cover_plane;
  uint count;
};
struct ListEntry {
  uint depth_and_low;
  uint high_and_strip;
  uint triangle;
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LightViews { LightView at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Leaves { Leaf at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Entries { ListEntry at[]; };

// The corners of a triangle, as a walk reads them: in one place.
struct TriangleCorners {
  vec3 p0, p1, p2;
  uint reserved;
};

#ifdef BY_PAIRS

struct LeafPairs {
  uint64_t a, b, c, d;
};
struct CornerPairs {
  uint64_t a, b, c, d, e;
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LeavesByPairs { LeafPairs at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Corners { CornerPairs at[]; };

Leaf whole_leaf(uint n) {
  LeafPairs leaf = LeavesByPairs(push.leaves).at[n];
  vec2 a = floats_of(leaf.a), b = floats_of(leaf.b), c = floats_of(leaf.c), d = floats_of(leaf.d);
  return Leaf(vec3(a, b.x), floatBitsToUint(b.y), vec3(c, d.x), floatBitsToUint(d.y));
}

TriangleCorners corners_of(uint triangle) {
  CornerPairs corners = Corners(push.corners).at[triangle];
  vec2 a = floats_of(corners.a), b = floats_of(corners.b), c = floats_of(corners.c), d = floats_of(corners.d);
  return TriangleCorners(vec3(a, b.x), vec3(b.y, c), vec3(d, floats_of(corners.e).x), 0u);
}

#else

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer Corners { TriangleCorners at[]; };

Leaf whole_leaf(uint n) { return Leaves(push.leaves).at[n]; }
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
  return Uints(push.grid).at[view.cells + (place.face << (2u * kTopLevel)) + (cell.y << kTopLevel) + cell.x];
}

// The leaf within the cell.
uint leaf_at(uint cell, Place place) {
  uint bits = cell & ((1u << kDepthBits) - 1u);
  uvec2 sub = (place.at >> (kCellShift - bits)) & ((1u << bits) - 1u);
  return Uints(push.grid).at[(cell >> kDepthBits) + (sub.y << bits) + sub.x];
}

// The place in 256ths of the leaf's side, x in the low half. `count`: Leaf::count, which contains the level.
uint place_in_leaf(uvec2 at, uint count) {
  uvec2 place = ((at << (count >> kCountBits)) & ((1u << kIndexBits) - 1u)) >> (kIndexBits - 8u);
  return place.x | place.y << 16;
}

bool in_front(ListEntry entry, float depth) { return depth * uintBitsToFloat(entry.depth_and_low >> 1) < 1.0; }

// Whether the place lies in the entry's box and strip.
bool holds(ListEntry entry, uint place) {
  uint x = place & 255u, y = place >> 16, low = entry.depth_and_low, high = entry.high_and_strip;
  bool in_box = (x >> 3) >= (low & 31u) && (y >> 3) >= ((low >> 5) & 31u) && (x >> 3) <= (high & 31u) &&
                (y >> 3) <= ((high >> 5) & 31u);
  int strip = int(high);
  int across_x = 32 - ((strip >> 10) & 63), across_y = 32 - abs(across_x);
  int across = (across_x * int(x) + across_y * int(y)) >> 6;
  return in_box && across >= bitfieldExtract(strip, 16, 8) && across <= strip >> 24;
}
