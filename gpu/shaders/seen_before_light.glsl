// What a triangle, as seen from a surface, does to all points of an area light at once.
float sum_of(vec3 v) { return abs(v.x) + abs(v.y) + abs(v.z); }

const uint kMissesLight = 0u, kHidesLight = 1u, kCutsLight = 2u;

// Whether the triangle certainly meets no segment to a point of the light, as one of its edges has every such point on
// one side and another one has them all on the other; or certainly meets them all, as every edge has them on the same
// side, and its plane, which no rounding can turn, lies between the origin and every point. With room for all rounding.
uint seen_before_light(SeenTriangle t, vec3 to_middle, float radius) {
  float far = sum_of(to_middle) + radius;
  vec3 e0 = t.c - t.a, e1 = t.a - t.b;
  float size0 = sum_of(e0), size1 = sum_of(e1), distance = sum_of(t.a);
  vec3 sides = vec3(dot(t.side0, to_middle), dot(t.side1, to_middle), dot(t.side2, to_middle));
  vec3 swing = radius * vec3(length(t.side0), length(t.side1), length(t.side2)) * 1.001 +
               4e-6 * far * (distance + sum_of(t.b) + sum_of(t.c)) * vec3(size0, size1, sum_of(t.b - t.c));
  vec3 most = sides + swing, least = sides - swing;
  float most_least = min(most.x, min(most.y, most.z)), least_most = max(least.x, max(least.y, least.z));
  if (most_least < 0.0 && least_most > 0.0) return kMissesLight;
  bool within = min(least.x, min(least.y, least.z)) > 0.0 || max(most.x, max(most.y, most.z)) < 0.0;
  vec3 n = cross(e0, e1);
  float height = dot(n, t.a), across = dot(n, to_middle);
  height = across < 0.0 ? -height : height;
  // The least height and slope keep the place where a segment meets the triangle, as it is computed, near enough to it.
  float blur = size0 * size1;
  bool between = height > 8e-3 * blur * distance && abs(across) > 1.2e-2 * blur * far &&
                 height < abs(across) - 1.001 * radius * length(n) - 1e-5 * blur * (far + distance);
  return within && between ? kHidesLight : kCutsLight;
}
