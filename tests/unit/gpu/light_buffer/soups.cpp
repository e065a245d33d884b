#include "tests/unit/gpu/light_buffer/soups.h"

#include <cmath>

namespace gnomon::test {
namespace {

using glm::vec3;

float between(Random& random, float low, float high) {
  return std::uniform_real_distribution<float>(low, high)(random);
}

uint32_t below(Random& random, uint32_t n) { return std::uniform_int_distribution<uint32_t>(0, n - 1)(random); }

vec3 in_box(Random& random, float half) {
  return {between(random, -half, half), between(random, -half, half), between(random, -half, half)};
}

// 10^low to 10^high, evenly over the exponents.
float magnitude(Random& random, float low, float high) { return std::pow(10.0f, between(random, low, high)); }

using Triangle = std::array<vec3, 3>;

Triangle around(Random& random, vec3 center, float size) {
  return {center + in_box(random, size), center + in_box(random, size), center + in_box(random, size)};
}

Triangle sliver(Random& random) {
  const vec3 a = in_box(random, 5), b = in_box(random, 5);
  const float along = between(random, -0.2f, 1.2f);
  return {a, b, a + along * (b - a) + in_box(random, magnitude(random, -6, -2))};
}

Triangle edge_on(Random& random, vec3 light) {
  const vec3 a = in_box(random, 5), b = in_box(random, 5);
  const float s = between(random, -1, 2), t = between(random, -1, 2);
  Triangle triangle = {a, b, light + s * (a - light) + t * (b - light)};
  if (below(random, 2) == 0) triangle[2] += in_box(random, magnitude(random, -7, -3));
  return triangle;
}

Triangle touching(Random& random, vec3 light) {
  const vec3 a = in_box(random, 4), b = in_box(random, 4);
  switch (below(random, 4)) {
    case 0: return {light, a, b};
    case 1: return {a, light + (light - a), b};                // the light on an edge
    case 2: return {a, b, light + (light - a) + (light - b)};  // inside
    default: return around(random, light, magnitude(random, -6, -1));
  }
}

Triangle astride(Random& random, vec3 light) {
  const vec3 a = light + in_box(random, magnitude(random, -2, 0.7f));
  const vec3 behind = light - magnitude(random, -1, 1) * (a - light) + in_box(random, magnitude(random, -3, 0));
  return {a, behind, light + in_box(random, magnitude(random, -1, 1))};
}

Triangle on_lattice(Random& random) {
  const auto snap = [](vec3 p) { return glm::round(p); };
  return {snap(in_box(random, 4)), snap(in_box(random, 4)), snap(in_box(random, 4))};
}

void add(Soup& soup, const Triangle& t) {
  const uint32_t first = static_cast<uint32_t>(soup.mesh.positions.size());
  soup.mesh.positions.insert(soup.mesh.positions.end(), t.begin(), t.end());
  soup.mesh.triangles.push_back({first, first + 1, first + 2});
}

void add_quad(Soup& soup, vec3 corner, vec3 u, vec3 v) {
  add(soup, {corner, corner + u, corner + u + v});
  add(soup, {corner, corner + u + v, corner + v});
}

void add_sheets(Soup& soup, Random& random) {
  for (int wall = 0; wall < 6; ++wall) {
    const vec3 corner = in_box(random, 5);
    const int axis = static_cast<int>(below(random, 3));
    vec3 u(0), v(0);
    u[(axis + 1) % 3] = between(random, 1, 6);
    v[(axis + 2) % 3] = between(random, 1, 6);
    const int n = 1 + static_cast<int>(below(random, 5));
    for (int i = 0; i < n; ++i) {
      for (int j = 0; j < n; ++j) {
        const float f = 1.0f / static_cast<float>(n);
        add_quad(soup, corner + static_cast<float>(i) * f * u + static_cast<float>(j) * f * v, f * u, f * v);
      }
    }
  }
}

void add_boxes(Soup& soup, vec3 light, Random& random) {
  for (int box = 0; box < 4; ++box) {
    const vec3 half(magnitude(random, -1.5f, 0.8f), magnitude(random, -1.5f, 0.8f), magnitude(random, -1.5f, 0.8f));
    const vec3 low = light - half * between(random, 0.05f, 1.0f);
    for (int axis = 0; axis < 3; ++axis) {
      vec3 u(0), v(0), across(0);
      u[(axis + 1) % 3] = 2 * half[(axis + 1) % 3];
      v[(axis + 2) % 3] = 2 * half[(axis + 2) % 3];
      across[axis] = 2 * half[axis];
      if (below(random, 3) != 0) add_quad(soup, low, u, v);
      if (below(random, 3) != 0) add_quad(soup, low + across, u, v);
    }
  }
}

Triangle make_triangle(Shape shape, vec3 light, Random& random) {
  switch (shape) {
    case Shape::even: return around(random, in_box(random, 4), 1);
    case Shape::tiny: return around(random, in_box(random, 1), magnitude(random, -5, -2));
    case Shape::huge: return around(random, in_box(random, 5), magnitude(random, 0, 1.5f));
    case Shape::slivers: return sliver(random);
    case Shape::edge_on: return edge_on(random, light);
    case Shape::touching: return touching(random, light);
    case Shape::astride: return astride(random, light);
    default: return on_lattice(random);
  }
}

gpu::exact::TracedLight make_light(Shape shape, Lamp lamp, Random& random) {
  gpu::exact::TracedLight light{};
  light.kind = static_cast<uint32_t>(lamp);
  light.position = in_box(random, 3);
  if (shape == Shape::grid) light.position = glm::round(light.position);
  light.direction = glm::normalize(in_box(random, 1) + vec3(0, 1e-3f, 0));
  if (shape == Shape::grid) light.direction = vec3(0, -1, 0);
  light.outer_cone_cos = between(random, -0.2f, 0.9f);
  return light;
}

void measure(Soup& soup) {
  soup.bounds = {soup.mesh.positions.front(), soup.mesh.positions.front()};
  for (const vec3& p : soup.mesh.positions) {
    soup.bounds = {glm::min(soup.bounds.min, p), glm::max(soup.bounds.max, p)};
  }
}

}  // namespace

std::string name(Shape shape) {
  constexpr const char* names[] = {"even",     "tiny",   "huge",    "slivers", "edge_on",
                                   "touching", "sheets", "astride", "around",  "grid"};
  return names[static_cast<size_t>(shape)];
}

std::string name(Lamp lamp) {
  constexpr const char* names[] = {"point", "spot", "directional"};
  return names[static_cast<size_t>(lamp)];
}

Soup make_soup(Shape shape, Lamp lamp, int triangles, Random& random) {
  Soup soup;
  soup.light = make_light(shape, lamp, random);
  // Edge-on to a directional light: in planes through a point far up the light.
  const vec3 source = lamp == Lamp::directional ? -1e6f * soup.light.direction : soup.light.position;
  if (shape == Shape::sheets) add_sheets(soup, random);
  if (shape == Shape::around) add_boxes(soup, soup.light.position, random);
  const Shape each = shape == Shape::sheets || shape == Shape::around ? Shape::even : shape;
  for (int t = 0; t < triangles; ++t) add(soup, make_triangle(each, source, random));
  soup.mesh.opaque_count = static_cast<uint32_t>(soup.mesh.triangles.size());
  measure(soup);
  soup.light.reach = lamp == Lamp::directional ? 2.1f * glm::distance(soup.bounds.min, soup.bounds.max) : 0.0f;
  return soup;
}

gpu::exact::SurfacePoint make_point(const Soup& soup, Random& random) {
  const glm::uvec3 t = soup.mesh.triangles[below(random, static_cast<uint32_t>(soup.mesh.triangles.size()))];
  const vec3 a = soup.mesh.positions[t.x], b = soup.mesh.positions[t.y], c = soup.mesh.positions[t.z];
  float s = between(random, 0, 1), r = between(random, 0, 1);
  if (below(random, 4) == 0) r = 0;      // on an edge
  if (below(random, 8) == 0) s = r = 0;  // at a corner
  vec3 position = a + s * (1 - r) * (b - a) + r * (c - a);
  switch (below(random, 4)) {
    case 0: position = in_box(random, 5); break;
    case 1:  // behind the triangle, or before it, as the light sees it
      position += (soup.light.kind == 2 ? -soup.light.direction : soup.light.position - position) *
                  (between(random, -1, 1) * magnitude(random, -6, 0));
      break;
    default: break;
  }
  position = glm::clamp(position, soup.bounds.min, soup.bounds.max);
  const vec3 to_light = soup.light.kind == 2 ? -soup.light.direction : soup.light.position - position;
  const vec3 normal = glm::cross(b - a, c - a);
  const float length = glm::length(normal);
  vec3 unit = length > 0 ? normal / length : vec3(0, 1, 0);
  if (glm::dot(unit, to_light) < 0) unit = -unit;
  return {position, unit};
}

bool blocked(const scenes::WorldMesh& mesh, const gpu::exact::ShadowSegment& segment) {
  for (const glm::uvec3& t : mesh.triangles) {
    if (gpu::exact::segment_meets_triangle(segment.origin, segment.direction, mesh.positions[t.x],
                                           mesh.positions[t.y], mesh.positions[t.z])) {
      return true;
    }
  }
  return false;
}

}  // namespace gnomon::test
