#include "scenes/light_samples.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace gnomon::scenes {
namespace {

constexpr uint32_t kBits = 10;  // of an index; 1,024 points
using Directions = std::array<uint16_t, kBits>;

// Direction numbers of the second and third dimension; the first is the van der Corput sequence.
constexpr std::array<Directions, 3> kDirections{{{1, 1, 1, 1, 1, 1, 1, 1, 1, 1},
                                                 {1, 3, 5, 15, 17, 51, 85, 255, 257, 771},
                                                 {1, 3, 3, 9, 29, 23, 71, 197, 209, 627}}};

double coordinate(uint32_t index, const Directions& directions) {
  uint32_t value = 0;
  for (uint32_t bit = 0; bit < kBits; ++bit) {
    if (index >> bit & 1) value ^= static_cast<uint32_t>(directions[bit]) << (kBits - 1 - bit);
  }
  return static_cast<double>(value) / (1u << kBits);
}

// The half-angle w at which (w - sin w cos w) / (pi / 2) is `share`: points at the distances sin(w) of a ball's middle,
// in all directions alike, look like an evenly bright disc from every side.
double ball_angle(double share) {
  double low = 0.0, high = glm::half_pi<double>();
  for (int step = 0; step < 60; ++step) {
    const double middle = 0.5 * (low + high);
    (middle - std::sin(middle) * std::cos(middle) < share * glm::half_pi<double>() ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// Of the unit sphere: even in z and round it, which makes it even on the sphere (Archimedes).
glm::dvec3 on_sphere(const glm::dvec3& at) {
  const double z = 1.0 - 2.0 * at.x, across = std::sqrt(1.0 - z * z), angle = glm::two_pi<double>() * at.y;
  return {across * std::cos(angle), across * std::sin(angle), z};
}

glm::dvec3 on_area(const LightArea& area, const glm::dvec3& at) {
  const glm::dvec3 u(area.u), v(area.v);
  const double angle = glm::two_pi<double>() * at.y;
  switch (area.shape) {
    case LightShape::point: return glm::dvec3(0.0);
    case LightShape::rectangle: return (2.0 * at.x - 1.0) * u + (2.0 * at.y - 1.0) * v;
    case LightShape::disc: return std::sqrt(at.x) * (std::cos(angle) * u + std::sin(angle) * v);
    case LightShape::sphere: return static_cast<double>(area.reach()) * std::sin(ball_angle(at.z)) * on_sphere(at);
  }
  return glm::dvec3(0.0);
}

}  // namespace

glm::dvec3 sample_fraction(uint32_t index, uint32_t count) {
  glm::dvec3 at;
  for (int d = 0; d < 3; ++d) at[d] = coordinate(index, kDirections[static_cast<size_t>(d)]) + 0.5 / count;
  return at;
}

std::vector<glm::vec3> sample_offsets(const LightArea& area, uint32_t samples) {
  const uint32_t count = kSamplePatterns * samples;
  std::vector<glm::vec3> offsets(count);
  for (uint32_t i = 0; i < count; ++i) offsets[i] = glm::vec3(on_area(area, sample_fraction(i, count)));
  return offsets;
}

std::vector<glm::vec3> occlusion_points(uint32_t segments) {
  const uint32_t count = kSamplePatterns * segments;
  std::vector<glm::vec3> points(count);
  for (uint32_t i = 0; i < count; ++i) points[i] = glm::vec3(on_sphere(sample_fraction(i, count)));
  return points;
}

float occlusion_radius(const Scene& scene) {
  const float stated = scene.surroundings.ambient_reach;
  const float by_size = std::min(glm::distance(scene.bounds.min, scene.bounds.max) / 16.0f, 1.0f);
  return 0.5f * (stated > 0.0f ? stated : by_size);
}

}  // namespace gnomon::scenes
