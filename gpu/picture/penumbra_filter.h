// Filters the counts of an area light's mask: what a pixel shows of a penumbra becomes the mean over its neighbours'
// sample points, of which every 4x4 window of pixels has all (scenes/light_samples.h). An approximation, which clients
// may switch on; without it a picture is exactly count / k. shaders/shade.glsl has the same rule.
//
// A neighbour counts if it shows the same surface: its normal within 8 degrees, and its point within kOffPlane of the
// pixel's plane, as a share of its distance from the camera. Where a window holds wholly lit and wholly dark pixels
// side by side, the edge is sharper than the window, and the pixel keeps its own count.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

namespace gnomon::gpu {

inline constexpr int kPenumbraReach = 2;  // pixels to each side
// The mean of the four 4x4 windows that contain the pixel's neighbourhood evenly.
inline constexpr std::array<float, 5> kPenumbraWeights{1, 2, 2, 2, 1};
inline constexpr float kSameNormal = 0.99f;
inline constexpr float kOffPlane = 0.004f;

struct PenumbraPixel {
  bool shows_surface = false;
  bool cares = false;  // the pair was asked
  glm::vec3 position{0.0f};
  glm::vec3 normal{0.0f};
  float seen = 0;  // share of the sample points, 0 to 1
};

inline bool same_surface(const PenumbraPixel& a, const PenumbraPixel& b, const glm::vec3& camera) {
  if (!b.shows_surface || !b.cares || glm::dot(a.normal, b.normal) < kSameNormal) return false;
  const float off = glm::abs(glm::dot(a.normal, b.position - a.position));
  return off <= kOffPlane * glm::distance(a.position, camera);
}

// `pixel(dx, dy)`: the neighbour there; beyond the picture one that shows no surface.
template <class Pixel>
float filtered_share(const glm::vec3& camera, Pixel pixel) {
  const PenumbraPixel here = pixel(0, 0);
  float sum = 0, weights = 0;
  bool lit = false, dark = false;
  for (int dy = -kPenumbraReach; dy <= kPenumbraReach; ++dy) {
    for (int dx = -kPenumbraReach; dx <= kPenumbraReach; ++dx) {
      const PenumbraPixel other = pixel(dx, dy);
      if (!same_surface(here, other, camera)) continue;
      const float weight = kPenumbraWeights[static_cast<size_t>(dx + kPenumbraReach)] *
                           kPenumbraWeights[static_cast<size_t>(dy + kPenumbraReach)];
      sum += weight * other.seen;
      weights += weight;
      lit = lit || other.seen == 1.0f;
      dark = dark || other.seen == 0.0f;
    }
  }
  return (lit && dark) || weights == 0 ? here.seen : sum / weights;
}

}  // namespace gnomon::gpu
