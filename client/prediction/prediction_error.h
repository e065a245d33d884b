// Measures how wrong predicted masks were: bit by bit against those that arrived later (dissertation 4.1).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/light_planes.h"
#include "common/tile_mask.h"

namespace gnomon::client {

// The masks, of one plane for each light, of the first 32 lights by pixel, row by row; bit i of a pixel is light i.
struct LightBits {
  uint32_t width = 0;
  uint32_t height = 0;
  uint32_t lights = 0;
  std::vector<uint32_t> pixels;

  LightBits() = default;
  explicit LightBits(const TileMaskView& masks);
  uint32_t all() const { return lights < 32 ? (1u << lights) - 1 : ~0u; }
};

// Part of a picture, in pixels.
struct PixelRect {
  uint32_t left = 0, top = 0, width = 0, height = 0;

  bool contains(uint32_t x, uint32_t y) const { return x - left < width && y - top < height; }
};

struct PredictionError {
  uint64_t pixels = 0;  // of the picture
  uint64_t bits = 0;    // compared; of an area light, sample points
  uint64_t wrong = 0;
  uint64_t falsely_dark = 0;  // of these, predicted dark

  // The dissertation's figure: wrong bits of the picture, by the number of its lights.
  double per_light(uint32_t lights) const { return static_cast<double>(wrong) / lights; }
  double share() const { return bits ? static_cast<double>(wrong) / static_cast<double>(bits) : 0; }
  // Share of all bits of the picture, including those that do not matter.
  double share_of_picture(uint32_t lights) const {
    return pixels ? per_light(lights) / static_cast<double>(pixels) : 0;
  }
  PredictionError& operator+=(const PredictionError& other);
};

// Compares a prediction of the part `shown` of `fresh` with `fresh`. Each predicted pixel has the bits of the pixel of
// `seen` that `sources` names (gpu/picture/reprojection.h; shown.width x shown.height entries, row by row) if that lies
// within `traced`; otherwise it is lit. Only bits that `care` has set (an entry for each pixel of `fresh`) count; if
// `care` is empty, all bits of the pixels that have a source count.
PredictionError compare(const LightBits& seen, std::span<const uint32_t> sources, const PixelRect& traced,
                        const LightBits& fresh, std::span<const uint32_t> care, const PixelRect& shown);

// An estimate from every `step`-th pixel of every `step`-th row, with all of `seen` traced and without `care`. Both masks
// have one plane for each light or, of area lights, `planes`: the numbers of points that they see are then compared.
PredictionError compare_some(const TileMaskView& seen, std::span<const uint32_t> sources, const TileMaskView& fresh,
                             const PixelRect& shown, uint32_t step, const LightPlanes& planes = {});

}  // namespace gnomon::client
