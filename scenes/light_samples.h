// The points of an area light to which soft shadows are traced.
//
// They are fixed, so that every server, tracer and test counts the same ones: points of a Sobol sequence (Sobol 1967;
// the direction numbers are Joe and Kuo's of 2008), mapped to the light's shape. Pixels of a block of 4x4 take
// different points: the pixel of pattern p takes points p * k to p * k + k - 1 of the first 16 k, when it asks for k.
// Each such run is stratified by itself, those of an aligned 2x2 block together, and those of any 4x4 window together,
// which is what makes a filter over neighbours converge as fast as more points for each pixel would.
//
// protocol/WIRE.md states the same, for a second implementation.
#pragma once

#include <algorithm>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "common/light_planes.h"
#include "scenes/scene.h"

namespace gnomon::scenes {

inline constexpr uint32_t kSamplePatterns = 16;

inline bool has_area_lights(const Scene& scene) {
  return std::any_of(scene.lights.begin(), scene.lights.end(),
                     [](const Light& light) { return light.area.shape != LightShape::point; });
}

// The pattern of pixel (x, y) of the traced buffer.
constexpr uint32_t sample_pattern(uint32_t x, uint32_t y) {
  const auto order = [](uint32_t i, uint32_t j) { return ((i ^ j) << 1 | j) & 3; };
  return 4 * order(x >> 1 & 1, y >> 1 & 1) + order(x & 1, y & 1);
}

// Point `index` of the sequence in three dimensions, each 0 to 1, in the middle of its interval of 1 / `count`; `count`
// is the number of points in use, a power of two up to 1,024.
glm::dvec3 sample_fraction(uint32_t index, uint32_t count);

// The offsets from the light's position of its kSamplePatterns * samples points, pattern by pattern. All zero for a
// light without an area. `samples`: a power of two; sessions have 4 or 16, references for comparison up to 64.
std::vector<glm::vec3> sample_offsets(const LightArea& area, uint32_t samples);

// The points to which the occlusion of the ambient light is traced, on a sphere that touches the surface: unit vectors
// from its middle, `segments` for each of the kSamplePatterns patterns (sessions have kOcclusionSegments, references for
// comparison up to 64). Spread evenly over the sphere they lie in
// directions from the surface that are spread by the cosine, and the flatter a segment is, the shorter.
std::vector<glm::vec3> occlusion_points(uint32_t segments = kOcclusionSegments);

// The radius of that sphere in a scene: half of its ambient_reach, or of 1/16 of its bounds' diagonal and 1 m at most.
float occlusion_radius(const Scene& scene);

}  // namespace gnomon::scenes
