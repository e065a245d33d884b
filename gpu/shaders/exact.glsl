// The definition of an exact mask: the surface point, the shadow segment and the triangle test of every tracer.
//
// The file is written in the common subset of GLSL and C++ with GLM: tests include it in C++ (through gpu/exact_cpp.h)
// and compare masks bit for bit, so that nothing here may depend on contraction to FMA or on the order in which a
// compiler adds. EXACT marks what GLSL must compute as written (`precise`).

// A shadow segment: points origin + t * direction, 0 < t < 1. `traced` is false if the bit is 0 without tracing.
struct ShadowSegment {
  vec3 origin;
  vec3 direction;
  bool traced;
};

// Written out, because a driver may add the terms of the built-in functions in any order.
EXACT_FN float exact_dot(vec3 a, vec3 b) {
  EXACT float sum = a.x * b.x + a.y * b.y + a.z * b.z;
  return sum;
}

EXACT_FN vec3 exact_cross(vec3 a, vec3 b) {
  EXACT vec3 product = vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
  return product;
}

struct SurfacePoint {
  vec3 position;
  vec3 normal;  // geometric, unit, on the camera's side
};

// The point of triangle (p0, p1, p2) that the pixel's ray meets. `ray` has length 1 along the camera's forward axis,
// so that its parameter is the view depth; clamping that to the triangle's own depths keeps pixels of edge-on
// triangles, whose planes the ray meets almost anywhere, on the triangle.
EXACT_FN SurfacePoint surface_point(vec3 camera, vec3 forward, vec3 ray, vec3 p0, vec3 p1, vec3 p2) {
  EXACT vec3 a = p0 - camera;
  EXACT vec3 b = p1 - camera;
  EXACT vec3 c = p2 - camera;
  EXACT vec3 n = exact_cross(p1 - p0, p2 - p0);
  EXACT float za = exact_dot(a, forward);
  EXACT float zb = exact_dot(b, forward);
  EXACT float zc = exact_dot(c, forward);
  float nearest = min(za, min(zb, zc));
  float farthest = max(za, max(zb, zc));
  EXACT float across = exact_dot(n, ray);
  EXACT float depth = across == 0.0f ? nearest : exact_dot(n, a) / across;
  EXACT float clamped = min(max(depth, nearest), farthest);
  EXACT vec3 unit = n / sqrt(exact_dot(n, n));
  SurfacePoint s;
  EXACT vec3 position = camera + clamped * ray;
  s.position = position;
  s.normal = across > 0.0f ? -unit : unit;
  return s;
}

// The point from which shadow segments start. It is off the surface, on the camera's side, by more than the rounding of
// the surface point, which grows with the coordinates of point and camera, and by less than is visible.
EXACT_FN vec3 segment_origin(vec3 camera, SurfacePoint s) {
  float largest = max(max(abs(s.position.x), max(abs(s.position.y), abs(s.position.z))),
                      max(abs(camera.x), max(abs(camera.y), abs(camera.z))));
  EXACT vec3 origin = s.position + s.normal * (largest * (1.0f / 65536.0f));
  return origin;
}

// A light as the tracers use it. kind: 0 point, 1 spot, 2 directional. reach: range in metres, 0 if unlimited; for a
// directional light the length of its segments, which exceeds the scene. direction: unit, the way the light shines.
struct TracedLight {
  vec3 position;
  float reach;
  vec3 direction;
  float outer_cone_cos;
  uint kind;
  float radius;  // for builders: no point of it that is traced is farther from the position; 0 where only that is
};

// The segment from a surface point, whose segment_origin is `origin`, to a light. It is not traced, and the bit is 0, if
// the light is behind the surface (so that the segment would start by crossing that surface) or the point is out of range
// or outside the cone.
EXACT_FN ShadowSegment segment_to_light(vec3 origin, vec3 normal, TracedLight light) {
  ShadowSegment segment;
  segment.origin = origin;
  if (light.kind == 2u) {
    EXACT vec3 along = light.direction * -light.reach;
    segment.direction = along;
    EXACT float facing = exact_dot(normal, along);
    segment.traced = facing > 0.0f;
    return segment;
  }
  EXACT vec3 to_light = light.position - origin;
  segment.direction = to_light;
  EXACT float facing = exact_dot(normal, to_light);
  EXACT float squared = exact_dot(to_light, to_light);
  bool reached = facing > 0.0f && (light.reach == 0.0f || squared <= light.reach * light.reach);
  if (light.kind == 1u) {
    EXACT float along = -exact_dot(to_light, light.direction);
    reached = reached && along > 0.0f && along * along >= light.outer_cone_cos * light.outer_cone_cos * squared;
  }
  segment.traced = reached;
  return segment;
}

EXACT_FN ShadowSegment shadow_segment(vec3 camera, SurfacePoint s, TracedLight light) {
  return segment_to_light(segment_origin(camera, s), s.normal, light);
}

// The segment from a surface to one sample point of an area light, of a pair whose segment to the light's middle is
// traced. `origin`: of that segment. The point is not seen, without tracing, if it is behind the surface.
EXACT_FN ShadowSegment sample_segment(vec3 origin, vec3 normal, vec3 point) {
  ShadowSegment segment;
  segment.origin = origin;
  EXACT vec3 to_point = point - origin;
  segment.direction = to_point;
  EXACT float facing = exact_dot(normal, to_point);
  segment.traced = facing > 0.0f;
  return segment;
}

// The segment that finds out whether something near occludes a surface's ambient light on one way: to a point of a sphere
// of that radius which touches the surface at `origin`. `on_sphere`: that point, from the sphere's middle, unit. Without
// tracing nothing occludes a segment that is flat or too short for the rounding.
EXACT_FN ShadowSegment occlusion_segment(vec3 origin, vec3 normal, vec3 on_sphere, float radius) {
  ShadowSegment segment;
  segment.origin = origin;
  EXACT vec3 to_point = (normal + on_sphere) * radius;
  segment.direction = to_point;
  EXACT float facing = exact_dot(normal, to_point);
  segment.traced = facing > 0.0f;
  return segment;
}

// A triangle as segments from one origin see it.
struct SeenTriangle {
  vec3 a, b, c;              // its corners, relative to the origin
  vec3 side0, side1, side2;  // dot with a direction: an edge's side
};

EXACT_FN SeenTriangle seen_triangle(vec3 origin, vec3 p0, vec3 p1, vec3 p2) {
  SeenTriangle t;
  EXACT vec3 a = p0 - origin;
  EXACT vec3 b = p1 - origin;
  EXACT vec3 c = p2 - origin;
  EXACT vec3 e0 = c - a;
  EXACT vec3 e1 = a - b;
  EXACT vec3 e2 = b - c;
  t.a = a;
  t.b = b;
  t.c = c;
  t.side0 = exact_cross(e0, c + a);
  t.side1 = exact_cross(e1, a + b);
  t.side2 = exact_cross(e2, b + c);
  return t;
}

// Whether the segment from that origin meets the triangle. The edge tests are in Pluecker form: an edge shared by two
// triangles gives exactly opposite numbers, so that no segment passes between neighbours. Both sides of the triangle
// count; the end points of the segment do not.
EXACT_FN bool meets_seen_triangle(SeenTriangle t, vec3 direction) {
  EXACT float u = exact_dot(t.side0, direction);
  EXACT float v = exact_dot(t.side1, direction);
  EXACT float w = exact_dot(t.side2, direction);
  if (min(u, min(v, w)) < 0.0f && max(u, max(v, w)) > 0.0f) return false;
  EXACT vec3 e0 = t.c - t.a;
  EXACT vec3 e1 = t.a - t.b;
  EXACT vec3 n = exact_cross(e0, e1);
  EXACT float across = exact_dot(n, direction);
  EXACT float height = exact_dot(n, t.a);
  // 0 < height / across < 1, without the division.
  if (across > 0.0f ? !(height > 0.0f && height < across) : !(height < 0.0f && height > across)) return false;
  // A triangle that is thinner than the rounding, as seen along the segment, may pass these tests anywhere in its
  // plane. Only a point near the triangle counts, so that tracers that sort triangles by place agree with those that do
  // not.
  vec3 lo = min(t.a, min(t.b, t.c));
  vec3 hi = max(t.a, max(t.b, t.c));
  vec3 far = max(abs(lo), abs(hi));
  EXACT float margin = max(far.x, max(far.y, far.z)) * (1.0f / 4096.0f);
  EXACT vec3 met = direction * (height / across);
  EXACT vec3 before = lo - met;
  EXACT vec3 after = met - hi;
  vec3 outside = max(before, after);
  return max(outside.x, max(outside.y, outside.z)) <= margin;
}

EXACT_FN bool segment_meets_triangle(vec3 origin, vec3 direction, vec3 p0, vec3 p1, vec3 p2) {
  return meets_seen_triangle(seen_triangle(origin, p0, p1, p2), direction);
}
