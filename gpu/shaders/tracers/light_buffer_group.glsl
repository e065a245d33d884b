// A tile's pixels as one: the boxes of their origins and normals, and the node of a light that holds what the light
// sees of them.

struct Group {
  vec3 lo;
  vec3 hi;
  vec3 normal_lo;
  vec3 normal_hi;
};

struct GroupNode {
  vec3 reference;
  vec3 near_plane;
  vec3 cover_plane;
  bool known;   // false: no node holds the group, the planes mean nothing
  bool wanted;  // false: no pixel of the group faces the light and is within its range
};

Group empty_group() { return Group(vec3(3e38), vec3(-3e38), vec3(2.0), vec3(-2.0)); }

void add_to_group(inout Group group, vec3 origin, vec3 normal, bool shown) {
  group.lo = shown ? min(group.lo, origin) : group.lo;
  group.hi = shown ? max(group.hi, origin) : group.hi;
  group.normal_lo = shown ? min(group.normal_lo, normal) : group.normal_lo;
  group.normal_hi = shown ? max(group.normal_hi, normal) : group.normal_hi;
}

// From each lane's pixels to those of all.
void close_group(inout Group group) {
  group.lo = subgroupMin(group.lo);
  group.hi = subgroupMax(group.hi);
  group.normal_lo = subgroupMin(group.normal_lo);
  group.normal_hi = subgroupMax(group.normal_hi);
}

GroupNode shuffled(GroupNode node, uint lane) {
  return GroupNode(subgroupShuffle(node.reference, lane), subgroupShuffle(node.near_plane, lane),
                   subgroupShuffle(node.cover_plane, lane), subgroupShuffle(node.known, lane), true);
}

// Largest value of dot(n, d) over two boxes.
float largest_dot(vec3 n_lo, vec3 n_hi, vec3 d_lo, vec3 d_hi) {
  vec3 most = max(max(n_lo * d_lo, n_lo * d_hi), max(n_hi * d_lo, n_hi * d_hi));
  return most.x + most.y + most.z;
}

// Rejects only what shadow_segment, with its rounding, rejects for every pixel of the group.
bool wanted(Group group, LightView light, TracedLight traced) {
  if (group.lo.x > group.hi.x) return false;
  bool directional = traced.kind == 2u;
  vec3 d_lo = directional ? light.direction : light.reference - group.hi;
  vec3 d_hi = directional ? light.direction : light.reference - group.lo;
  vec3 size = max(abs(d_lo), abs(d_hi));
  float facing = largest_dot(group.normal_lo, group.normal_hi, d_lo, d_hi);
  bool faces = facing > -1e-5 * (size.x + size.y + size.z);
  vec3 nearest = max(max(d_lo, -d_hi), vec3(0.0));
  bool reached = directional || traced.reach == 0.0 || dot(nearest, nearest) * 0.9999 <= traced.reach * traced.reach;
  return faces && reached;
}

// What the light sees of the box, in fixed point; rounding is padded by a unit on each side.
void flat_span(LightView light, Group group, out vec2 lo, out vec2 hi) {
  vec3 center = 0.5 * (group.lo + group.hi) - light.reference;
  vec3 half_size = 0.5 * (group.hi - group.lo);
  vec2 middle = vec2(dot(light.u_axis, center) + light.u_offset, dot(light.v_axis, center) + light.v_offset);
  vec2 half_span = vec2(dot(abs(light.u_axis), half_size), dot(abs(light.v_axis), half_size));
  lo = middle - half_span - 1.0;
  hi = middle + half_span + 1.0;
}

bool cube_span(LightView light, Group group, out uint face, out vec2 lo, out vec2 hi) {
  vec3 a = group.lo - light.reference;
  vec3 b = group.hi - light.reference;
  uint axis = largest_axis(abs(a + b));
  vec3 p = turned(a, axis);
  vec3 q = turned(b, axis);
  bool negative = p.z + q.z < 0.0;
  face = axis * 2u + (negative ? 1u : 0u);
  float nearest = negative ? -q.z : p.z;
  float farthest = negative ? -p.z : q.z;
  float most = kFixedPerUnit / nearest;
  float least = kFixedPerUnit / farthest;
  lo = min(p.xy * most, p.xy * least) + kFixedPerUnit * kFaceExtent - 1.0;
  hi = max(q.xy * most, q.xy * least) + kFixedPerUnit * kFaceExtent + 1.0;
  return nearest > 0.0;
}

GroupNode group_node(Group group, uint light_index) {
  LightView light = LightViews(push.views).at[light_index];
  Place place;
  vec2 lo, hi;
  bool seen = true;
  place.face = 0u;
  if (light.directional != 0u) {
    flat_span(light, group, lo, hi);
  } else {
    seen = cube_span(light, group, place.face, lo, hi);
  }
  seen = seen && lo.x >= 0.0 && lo.y >= 0.0 && hi.x < 16384.0 && hi.y < 16384.0;
  place.position = to_fixed(seen ? lo : vec2(0.0));
  // Nodes whose pitch is no less than the span.
  float span = max(hi.x - lo.x, hi.y - lo.y) + 1.0;
  seen = seen && span <= 1024.0;
  uint pitch_bits = max(uint(findMSB(uint(span))) + 1u, kIndexBits - kGroupLevel);
  Node node = Nodes(push.nodes).at[node_at(light, place, kIndexBits - pitch_bits)];
  GroupNode found;
  found.reference = light.reference;
  found.near_plane = node.near_plane;
  found.cover_plane = node.cover_plane;
  found.known = seen;
  found.wanted = wanted(group, light, frame.lights[light_index]);
  return found;
}
