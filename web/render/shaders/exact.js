// gpu/shaders/exact.glsl without what tracers alone need: the surface point, and whether a shadow segment is traced.
//
// GLSL ES has no `precise`: a driver may contract a product and a sum to one operation, or add in another order, and a
// pixel whose light is at the very edge of a plane, a range or a cone may then come out unlike the server's. Sums are
// written out in the server's order, so that a compiler has no reason of its own to change them.
export const EXACT = `
struct ShadowSegment {
  vec3 origin;
  vec3 direction;
  bool traced;
};

float exact_dot(vec3 a, vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

vec3 exact_cross(vec3 a, vec3 b) {
  return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}

struct SurfacePoint {
  vec3 position;
  vec3 normal;  // geometric, unit, on the camera's side
};

SurfacePoint surface_point(vec3 eye, vec3 ahead, vec3 ray, vec3 p0, vec3 p1, vec3 p2) {
  vec3 a = p0 - eye;
  vec3 b = p1 - eye;
  vec3 c = p2 - eye;
  vec3 n = exact_cross(p1 - p0, p2 - p0);
  float za = exact_dot(a, ahead);
  float zb = exact_dot(b, ahead);
  float zc = exact_dot(c, ahead);
  float nearest = min(za, min(zb, zc));
  float farthest = max(za, max(zb, zc));
  float across = exact_dot(n, ray);
  float depth = across == 0.0 ? nearest : exact_dot(n, a) / across;
  float clamped = min(max(depth, nearest), farthest);
  vec3 unit = n / sqrt(exact_dot(n, n));
  SurfacePoint s;
  s.position = eye + clamped * ray;
  s.normal = across > 0.0 ? -unit : unit;
  return s;
}

vec3 segment_origin(vec3 eye, SurfacePoint s) {
  float largest = max(max(abs(s.position.x), max(abs(s.position.y), abs(s.position.z))),
                      max(abs(eye.x), max(abs(eye.y), abs(eye.z))));
  return s.position + s.normal * (largest * (1.0 / 65536.0));
}

struct TracedLight {
  vec3 position;
  float reach;
  vec3 direction;
  float outer_cone_cos;
  uint kind;
};

ShadowSegment shadow_segment(vec3 eye, SurfacePoint s, TracedLight light) {
  ShadowSegment segment;
  segment.origin = segment_origin(eye, s);
  if (light.kind == 2u) {
    vec3 along = light.direction * -light.reach;
    segment.direction = along;
    float facing = exact_dot(s.normal, along);
    segment.traced = facing > 0.0;
    return segment;
  }
  vec3 to_light = light.position - segment.origin;
  segment.direction = to_light;
  float facing = exact_dot(s.normal, to_light);
  float squared = exact_dot(to_light, to_light);
  bool reached = facing > 0.0 && (light.reach == 0.0 || squared <= light.reach * light.reach);
  if (light.kind == 1u) {
    float along = -exact_dot(to_light, light.direction);
    reached = reached && along > 0.0 && along * along >= light.outer_cone_cos * light.outer_cone_cos * squared;
  }
  segment.traced = reached;
  return segment;
}
`;
