// The sample points of an area light as a surface sees them, and which of them may be behind a triangle. Walks meet a
// hundred triangles before a light whose picture hides few of the points each; an exact test for each point and triangle
// would be most of the work.
//
// A set of points has a bit for each: point 4 w + j is bit 8 j + 7 - w, which is where comparing four packed bytes
// leaves it. Includes what declares `push` with a soft frame before, and is C++ as well, for its test.

EXACT_FN uint point_bit(uint i) { return 0x80u << (8u * (i & 3u)) >> (i >> 2); }

EXACT_FN uint point_of(uint bit) { return 4u * (7u - (bit & 7u)) + (bit >> 3); }

// Precondition: 4 or 16 samples.
EXACT_FN uint all_points(uint samples) { return samples == 4u ? 0x80808080u : 0xf0f0f0f0u; }

// Places are on the plane before the origin, where the light's middle is at 64 and the whole light within 0 to 127.
struct SeenPoints {
  vec3 x_axis, y_axis, z_axis;
  float scale;
  uvec4 x, y;  // four points in each component
};

// No triangle is known not to be before them.
EXACT_FN SeenPoints points_anywhere() {
  SeenPoints seen;
  seen.x_axis = seen.y_axis = seen.z_axis = vec3(0.0f);
  seen.scale = 0.0f;
  seen.x = seen.y = uvec4(0u);
  return seen;
}

EXACT_FN uint packed(float place) { return uint(int(clamp(place, 0.0f, 127.0f))); }

// `first`: of the points.
EXACT_FN SeenPoints points_as_seen(vec3 origin, vec3 to_middle, float radius, uint first) {
  // So near a light has no picture.
  float squared = dot(to_middle, to_middle), narrow = squared - 1.01f * radius * radius;
  if (narrow <= 1.25f * radius * radius) return points_anywhere();
  SeenPoints seen = points_anywhere();
  seen.z_axis = to_middle * inversesqrt(squared);
  seen.x_axis = normalize(cross(seen.z_axis, abs(seen.z_axis.x) < 0.6f ? vec3(1.0f, 0.0f, 0.0f) : vec3(0.0f, 1.0f, 0.0f)));
  seen.y_axis = cross(seen.z_axis, seen.x_axis);
  seen.scale = 62.0f * sqrt(narrow) / radius;
  for (uint w = 0u; w < 4u; ++w) {
    for (uint j = 0u; j < 4u && 4u * w < push.soft.samples; ++j) {
      vec3 to_point = SAMPLE_POINT(first + 4u * w + j) - origin;
      float scale = seen.scale / dot(seen.z_axis, to_point);
      seen.x[w] |= packed(dot(seen.x_axis, to_point) * scale + 64.0f) << (8u * j);
      seen.y[w] |= packed(dot(seen.y_axis, to_point) * scale + 64.0f) << (8u * j);
    }
  }
  return seen;
}

// The points of which `low` to `high`, of both axes, may hold the place.
EXACT_FN uint points_within(SeenPoints seen, vec2 low, vec2 high) {
  const uint kHigh = 0x80808080u, kEach = 0x01010101u;
  if (any(lessThan(high, vec2(0.0f))) || any(greaterThanEqual(low, vec2(128.0f)))) return 0u;
  uint least_x = packed(low.x) * kEach, least_y = packed(low.y) * kEach;
  uint most_x = packed(high.x) * kEach | kHigh, most_y = packed(high.y) * kEach | kHigh;
  uint within = 0u;
  for (uint w = 0u; w < 4u; ++w) {
    uint in_x = ((seen.x[w] | kHigh) - least_x) & (most_x - seen.x[w]);
    uint in_y = ((seen.y[w] | kHigh) - least_y) & (most_y - seen.y[w]);
    within |= (in_x & in_y & kHigh) >> w;
  }
  return within;
}

// Every point whose segment the triangle may meet, and some others. The corners are relative to the origin. A hit, as
// segment_meets_triangle has it, is in the triangle's box, widened by 1/4096 of its farthest coordinate, and nothing else
// bounds it where the triangle is thinner than the rounding.
EXACT_FN uint points_behind(SeenPoints seen, vec3 a, vec3 b, vec3 c) {
  if (seen.scale == 0.0f) return ~0u;
  vec3 lo = min(a, min(b, c)), hi = max(a, max(b, c)), far = max(abs(lo), abs(hi));
  float farthest = max(far.x, max(far.y, far.z));
  vec3 middle = 0.5f * (lo + hi), half_size = 0.5f * (hi - lo) + farthest * (1.0f / 4000.0f);
  float depth = dot(seen.z_axis, middle), deep = dot(abs(seen.z_axis), half_size);
  if (depth - deep <= 1e-5f * farthest) return ~0u;
  float nearer = seen.scale / (depth - deep), farther = seen.scale / (depth + deep);
  vec2 at = vec2(dot(seen.x_axis, middle), dot(seen.y_axis, middle));
  vec2 reach = vec2(dot(abs(seen.x_axis), half_size), dot(abs(seen.y_axis), half_size));
  vec2 low = at - reach, high = at + reach;
  low = 63.98f + vec2(low.x * (low.x < 0.0f ? nearer : farther), low.y * (low.y < 0.0f ? nearer : farther));
  high = 64.02f + vec2(high.x * (high.x > 0.0f ? nearer : farther), high.y * (high.y > 0.0f ? nearer : farther));
  return points_within(seen, low, high);
}
