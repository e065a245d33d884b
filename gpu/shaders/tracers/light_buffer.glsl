// Light buffers as the shader reads them; gpu/tracers/light_buffer/light_buffer.h says what they are and why the
// answers are exact. query.cpp does the same in C++.
#include "tracers/alpha.glsl"

const uint kNone = 0xffffffffu;
const uint kRootLevel = 4u;
const uint kGroupLevel = 8u;
const uint kIndexBits = 14u;
const float kFaceExtent = 1.0625;
const float kFixedPerUnit = 16384.0 / (2.0 * kFaceExtent);

struct Node {
  vec3 near_plane;
  uint children;
  vec3 cover_plane;
  uint list;
};
struct LightView {
  vec3 reference;
  uint directional;
  vec3 u_axis;
  float u_offset;
  vec3 v_axis;
  float v_offset;
  vec3 depth_axis;
  uint roots;
  vec3 direction;  // directional: of every segment
  uint reserved;
};
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer Nodes { Node at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer LightViews { LightView at[]; };

// A place on a light's face: fixed-point position, and the axis along which depth is measured.
struct Place {
  uint face;
  uvec2 position;
  vec3 depth_axis;
};

uvec2 to_fixed(vec2 p) { return uvec2(clamp(p, vec2(0.0), vec2(16383.0))); }

// Components of v in the order (u, v, depth) of the faces of axis 0, 1 or 2.
vec3 turned(vec3 v, uint axis) { return axis == 0u ? v.yzx : axis == 1u ? v.zxy : v; }

uint largest_axis(vec3 size) { return size.x >= size.y && size.x >= size.z ? 0u : size.y >= size.z ? 1u : 2u; }

vec3 unit_axis(uint axis) { return vec3(axis == 0u, axis == 1u, axis == 2u); }

Place place_of(LightView light, vec3 rel) {
  Place place;
  if (light.directional != 0u) {
    place.face = 0u;
    place.position = to_fixed(vec2(dot(light.u_axis, rel) + light.u_offset, dot(light.v_axis, rel) + light.v_offset));
    place.depth_axis = light.depth_axis;
    return place;
  }
  uint axis = largest_axis(abs(rel));
  vec3 seen = turned(rel, axis);
  bool negative = seen.z < 0.0;
  place.face = axis * 2u + (negative ? 1u : 0u);
  place.position = to_fixed(seen.xy * (kFixedPerUnit / abs(seen.z)) + kFixedPerUnit * kFaceExtent);
  place.depth_axis = unit_axis(axis) * (negative ? -1.0 : 1.0);
  return place;
}

// The node of at most `level` that holds the place.
uint node_at(LightView light, Place place, uint level) {
  uint shift = kIndexBits - kRootLevel;
  uint node = light.roots + (place.face << (2u * kRootLevel)) + ((place.position.y >> shift) << kRootLevel) +
              (place.position.x >> shift);
  uint last = kIndexBits - level;
  for (uint children = Nodes(push.nodes).at[node].children; children != kNone && shift > last;) {
    --shift;
    node = children + ((place.position.y >> shift) & 1u) * 2u + ((place.position.x >> shift) & 1u);
    children = Nodes(push.nodes).at[node].children;
  }
  return node;
}

// Does a triangle of the list block the segment? `depth` of its origin.
bool list_blocks(uint list, float depth, vec3 origin, vec3 direction) {
  uint count = Uints(push.lists).at[list];
  for (uint k = 0u; k < count; ++k) {
    uint entry = list + 1u + 2u * k;
    uint triangle = Uints(push.lists).at[entry];
    if (depth * uintBitsToFloat(Uints(push.lists).at[entry + 1u]) < 1.0) return false;
    uvec3 corners = frame.triangles.at[triangle];
    vec3 p0 = frame.positions.at[corners.x];
    vec3 p1 = frame.positions.at[corners.y];
    vec3 p2 = frame.positions.at[corners.z];
    if (segment_meets_triangle(origin, direction, p0, p1, p2)) {
      if (triangle < push.first_masked || blocks_by_alpha(triangle, origin, direction, p0, p1, p2)) return true;
    }
  }
  return false;
}

// One pixel on its own.
bool blocked_alone(LightView light, vec3 rel, vec3 origin, vec3 direction) {
  Place place = place_of(light, rel);
  Node node = Nodes(push.nodes).at[node_at(light, place, kIndexBits)];
  if (dot(node.near_plane, rel) < 1.0) return false;
  if (dot(node.cover_plane, rel) > 1.0) return true;
  return list_blocks(node.list, dot(place.depth_axis, rel), origin, direction);
}
