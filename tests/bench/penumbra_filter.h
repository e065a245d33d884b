// The clients' filter of penumbrae in C++ (gpu/shaders/shade.glsl: window_pixel, same_surface, visible): the mean of the
// counts of an area light over the 4x4 pixels around a pixel that show the same surface. Neighbours whose pair was not
// asked are left out here; a client takes the bits that packing has given them.
#pragma once

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

inline bool same_surface(const PenumbraPixel& here, const PenumbraPixel& other) {
  if (!other.shows_surface || !other.cares) return false;
  const glm::vec3 between = other.position - here.position;
  return glm::dot(other.normal, here.normal) > 0.9f &&
         glm::abs(glm::dot(between, here.normal)) <= 0.25f * glm::length(between);
}

// `pixel(dx, dy)`: the neighbour there; beyond the picture one that shows no surface.
template <class Pixel>
float filtered_share(Pixel pixel) {
  const PenumbraPixel here = pixel(0, 0);
  float sum = 0;
  int count = 0;
  for (int dy = -1; dy <= 2; ++dy) {
    for (int dx = -1; dx <= 2; ++dx) {
      const PenumbraPixel other = pixel(dx, dy);
      if ((dx != 0 || dy != 0) && !same_surface(here, other)) continue;
      sum += other.seen;
      ++count;
    }
  }
  return sum / static_cast<float>(count);
}

}  // namespace gnomon::bench
