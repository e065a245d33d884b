// The clients' filter of penumbrae in C++ (gpu/shaders/shade.glsl: same_surface, visible). Neighbours whose pair was not
// asked are left out here; a client takes the bits that packing has given them.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

namespace gnomon::bench {

struct PenumbraPixel {
  bool shows_surface = false;
  bool cares = false;  // the pair was asked
  glm::vec3 position{0.0f};
  glm::vec3 normal{0.0f};
  float seen = 0;  // share of the sample points, 0 to 1
};

inline bool same_surface(const PenumbraPixel& here, const PenumbraPixel& other, const glm::vec3& camera) {
  if (!other.shows_surface || !other.cares || glm::dot(here.normal, other.normal) <= 0.99f) return false;
  const float off = glm::abs(glm::dot(here.normal, other.position - here.position));
  return off <= 0.004f * glm::distance(here.position, camera);
}

// `pixel(dx, dy)`: the neighbour there; beyond the picture one that shows no surface.
template <class Pixel>
float filtered_share(const glm::vec3& camera, Pixel pixel) {
  constexpr std::array<float, 5> kWeights{1, 2, 2, 2, 1};
  const PenumbraPixel here = pixel(0, 0);
  float sum = 0, weights = 0;
  bool lit = false, dark = false;
  for (int dy = -2; dy <= 2; ++dy) {
    for (int dx = -2; dx <= 2; ++dx) {
      const PenumbraPixel other = pixel(dx, dy);
      if ((dx != 0 || dy != 0) && !same_surface(here, other, camera)) continue;
      const float weight = kWeights[static_cast<size_t>(dx + 2)] * kWeights[static_cast<size_t>(dy + 2)];
      sum += weight * other.seen;
      weights += weight;
      lit = lit || other.seen == 1.0f;
      dark = dark || other.seen == 0.0f;
    }
  }
  return lit && dark ? here.seen : sum / weights;
}

}  // namespace gnomon::bench
