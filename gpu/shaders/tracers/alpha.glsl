#ifndef ALPHA_GLSL
#define ALPHA_GLSL
// The alpha test at the point where a segment meets triangle (p0, p1, p2). The Pluecker edge values are proportional to
// the barycentric weights.
bool blocks_by_alpha(uint triangle, vec3 origin, vec3 direction, vec3 p0, vec3 p1, vec3 p2) {
  precise vec3 a = p0 - origin;
  precise vec3 b = p1 - origin;
  precise vec3 c = p2 - origin;
  float u = exact_dot(exact_cross(c - a, c + a), direction);  // edge p2 p0: the weight of p1
  float v = exact_dot(exact_cross(a - b, a + b), direction);  // edge p0 p1: the weight of p2
  float w = exact_dot(exact_cross(b - c, b + c), direction);  // edge p1 p2: the weight of p0
  return passes_alpha_test(triangle, uv_at(triangle, vec3(w, u, v) / (u + v + w)));
}
#endif
