// How finely a frame's masks are counted: how many sample points of each area light a pixel looks at, and whether and how
// densely the occlusion of its ambient light is counted. A plain value, which client and server agree on.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string_view>

namespace gnomon {

inline constexpr uint32_t kMostSamples = 16;

// The sample points of an area light that one pixel asks for: 1 (the light's middle, as hard shadows), 4 or 16.
constexpr bool is_sample_count(uint32_t samples) { return samples == 1 || samples == 4 || samples == 16; }

// Which pixels count what occludes their ambient light: none, those of even column and row, or all.
enum class Occlusion : uint8_t { none = 0, half = 1, full = 2 };

constexpr std::string_view to_string(Occlusion occlusion) {
  return occlusion == Occlusion::none ? "none" : occlusion == Occlusion::half ? "half" : "full";
}

// The segments of a pixel that counts it.
inline constexpr uint32_t kOcclusionSegments = 8;

// The planes of a mask that say one of the numbers 0 to `most`, a power of two (common/light_planes.h).
constexpr uint32_t planes_of(uint32_t most) { return static_cast<uint32_t>(std::bit_width(most)); }
constexpr uint32_t planes_of(Occlusion occlusion) {
  return occlusion == Occlusion::none ? 0 : planes_of(kOcclusionSegments);
}

struct SampleCounts {
  uint8_t per_light = 1;  // points of each area light
  Occlusion occlusion = Occlusion::none;

  constexpr SampleCounts() = default;
  // A number alone is that of points of each area light.
  constexpr SampleCounts(uint32_t of_lights, Occlusion of_ambient = Occlusion::none)
      : per_light(static_cast<uint8_t>(of_lights)), occlusion(of_ambient) {}

  // Whether a mask has one bit for each light and pixel, and nothing else.
  constexpr bool is_hard() const { return per_light <= 1 && occlusion == Occlusion::none; }
  friend constexpr bool operator==(const SampleCounts&, const SampleCounts&) = default;
};

constexpr bool is_valid(SampleCounts counts) {
  return is_sample_count(counts.per_light) && counts.occlusion <= Occlusion::full;
}

// No more of either than both have.
constexpr SampleCounts fewest(SampleCounts a, SampleCounts b) {
  return {std::min(a.per_light, b.per_light), std::min(a.occlusion, b.occlusion)};
}

// One byte, as the protocol and the store of sessions have it: the points in the low six bits, the occlusion above.
constexpr uint8_t to_byte(SampleCounts counts) {
  return static_cast<uint8_t>(counts.per_light | static_cast<uint8_t>(counts.occlusion) << 6);
}
constexpr SampleCounts sample_counts_of(uint8_t byte) {
  return {static_cast<uint32_t>(byte & 0x3f), static_cast<Occlusion>(byte >> 6)};
}

}  // namespace gnomon
