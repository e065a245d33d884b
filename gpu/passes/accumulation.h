// What shaders/accumulate.comp reads from the host (scalar block layout, resource `accumulation`), and what it writes.
//
// The numbers that a mask counts (common/light_planes.h) stand in an order of their own: those of the area lights, then
// that of the ambient light. `shares` has a byte for each number and pixel of the newest mask's view: the mean over the
// masks that count for the pixel, in units that hold every mean of up to four of them exactly. Four numbers share a word,
// and the words of all pixels, row by row, come before the next four numbers.
#pragma once

#include "common/light_planes.h"
#include "gpu/scene/frame_uniforms.h"

namespace gnomon::gpu {

inline constexpr uint32_t kMostEarlierMasks = 3;            // the most that are looked up
inline constexpr uint32_t kWholeShare = 12 * kMostSamples;  // 12: a multiple of 1, 2, 3 and 4
static_assert(kWholeShare < 256 && kMostSamples % kOcclusionSegments == 0);

struct CountedNumber {
  uint32_t first_plane = 0;
  uint32_t most = 1;         // a share of 1
  uint32_t step = 1;         // pixels of columns and rows that are multiples of it have a number
  uint32_t accumulates = 0;  // 0: only the newest mask counts
};

struct Accumulation {
  uint32_t earlier = 0;            // masks
  uint32_t numbers = 0;            // in `counted`
  uint32_t resting_triangles = 0;  // the scene's others move: their surfaces show the newest mask alone
  uint32_t whole_share = kWholeShare;
  CountedNumber counted[kMaxLights + 1];
};

// The numbers that masks of these planes count.
inline uint32_t counted_numbers(const LightPlanes& planes) {
  uint32_t count = planes.occlusion() != Occlusion::none;
  for (uint32_t light = 0; light < planes.light_count(); ++light) count += planes.samples(light) > 1;
  return count;
}

inline uint64_t share_bytes(uint32_t width, uint32_t height, uint32_t numbers) {
  return uint64_t{width} * height * ((numbers + 3) / 4) * sizeof(uint32_t);
}

}  // namespace gnomon::gpu
