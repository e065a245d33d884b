// The round shapes: surfaces of revolution, and tubes along a curve.
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "scenes/assets/shapes.h"

namespace gnomon::scenes::assets {
namespace {

constexpr float kTwoPi = glm::two_pi<float>();

template <class V>
std::vector<V> catmull_rom(const std::vector<V>& p, int steps) {
  std::vector<V> out;
  const int n = static_cast<int>(p.size());
  for (int i = 0; i + 1 < n; ++i) {
    const V a = p[std::max(i - 1, 0)], b = p[i], c = p[i + 1], d = p[std::min(i + 2, n - 1)];
    for (int s = 0; s < steps; ++s) {
      const float t = static_cast<float>(s) / static_cast<float>(steps);
      out.push_back(0.5f * (2.0f * b + (c - a) * t + (2.0f * a - 5.0f * b + 4.0f * c - d) * (t * t) +
                            (3.0f * b - a - 3.0f * c + d) * (t * t * t)));
    }
  }
  out.push_back(p.back());
  return out;
}

}  // namespace

Mesh lathe(const std::vector<glm::vec2>& profile, int segments) {
  Mesh mesh;
  const auto ring = static_cast<uint32_t>(segments + 1);
  for (const glm::vec2& p : profile) {
    for (uint32_t s = 0; s < ring; ++s) {
      const float angle =
          kTwoPi * static_cast<float>(s % static_cast<uint32_t>(segments)) / static_cast<float>(segments);
      mesh.positions.emplace_back(p.x * std::cos(angle), p.y, -p.x * std::sin(angle));
    }
  }
  for (uint32_t i = 0; i + 1 < profile.size(); ++i) {
    if (profile[i] == profile[i + 1]) continue;  // a sharp edge: two rings at one place
    for (uint32_t s = 0; s + 1 < ring; ++s) {
      const uint32_t v = i * ring + s;
      add_quad(mesh, v, v + 1, v + ring + 1, v + ring);
    }
  }
  smooth_normals(mesh, 35.0f);
  return mesh;
}

Mesh turned_vessel(const std::vector<glm::vec2>& profile, int segments, int steps) {
  std::vector<glm::vec2> fine = curve(profile, steps);
  for (glm::vec2& p : fine) p.x = std::max(p.x, 0.0f);
  return lathe(fine, segments);
}

Mesh sphere(float radius, int segments) {
  std::vector<glm::vec2> profile;
  const int rings = segments / 2;
  for (int i = 0; i <= rings; ++i) {
    const float angle = glm::pi<float>() * (static_cast<float>(i) / static_cast<float>(rings) - 0.5f);
    const bool pole = i == 0 || i == rings;
    profile.emplace_back(pole ? 0.0f : radius * std::cos(angle), radius * std::sin(angle));
  }
  return lathe(profile, segments);
}

Mesh cylinder(float radius, float low, float high, int segments, float bevel) {
  const glm::vec2 a(radius - bevel, low), b(radius, low + bevel), c(radius, high - bevel), d(radius - bevel, high);
  return lathe({{0, low}, a, a, b, b, c, c, d, d, {0, high}}, segments);
}

std::vector<glm::vec3> curve(const std::vector<glm::vec3>& points, int steps) { return catmull_rom(points, steps); }
std::vector<glm::vec2> curve(const std::vector<glm::vec2>& points, int steps) { return catmull_rom(points, steps); }

Mesh tube(const std::vector<glm::vec3>& path, const std::function<float(float)>& radius, int sides) {
  Mesh mesh;
  const auto count = static_cast<uint32_t>(path.size());
  const auto ring = static_cast<uint32_t>(sides);
  glm::vec3 tangent = glm::normalize(path[1] - path[0]);
  glm::vec3 across = glm::vec3(pointing(tangent)[0]);
  for (uint32_t i = 0; i < count; ++i) {
    // The frame is transported along the path, so that the bar does not twist.
    tangent = glm::normalize(path[std::min(i + 1, count - 1)] - path[i > 0 ? i - 1 : 0]);
    across = glm::normalize(across - tangent * glm::dot(across, tangent));
    const glm::vec3 other = glm::cross(tangent, across);
    const float r = radius(static_cast<float>(i) / static_cast<float>(count - 1));
    for (uint32_t s = 0; s < ring; ++s) {
      const float angle = kTwoPi * static_cast<float>(s) / static_cast<float>(ring);
      mesh.positions.push_back(path[i] + r * (std::cos(angle) * across + std::sin(angle) * other));
    }
  }
  for (uint32_t i = 0; i + 1 < count; ++i) {
    for (uint32_t s = 0; s < ring; ++s) {
      const uint32_t a = i * ring + s, b = i * ring + (s + 1) % ring;
      add_quad(mesh, a, b, b + ring, a + ring);
    }
  }
  add_cap(mesh, 0, ring, true);
  add_cap(mesh, (count - 1) * ring, ring, false);
  smooth_normals(mesh, 60.0f);
  return mesh;
}

Mesh tube(const std::vector<glm::vec3>& path, float radius, int sides) {
  return tube(
      path, [radius](float) { return radius; }, sides);
}

}  // namespace gnomon::scenes::assets
