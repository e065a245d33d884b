#include "client/prediction/prediction_error.h"

#include <algorithm>
#include <bit>

namespace gnomon::client {

LightBits::LightBits(const TileMaskView& masks)
    : width(masks.grid.width),
      height(masks.grid.height),
      lights(std::min(masks.grid.planes, 32u)),
      pixels(size_t{width} * height) {
  for (uint32_t light = 0; light < lights; ++light)
    for (uint32_t tile = 0; tile < masks.grid.tile_count(); ++tile) {
      uint64_t word = masks.words[size_t{light} * masks.grid.tile_count() + tile];
      const uint32_t left = tile % masks.grid.tiles_x() * kTileSize, top = tile / masks.grid.tiles_x() * kTileSize;
      for (; word != 0; word &= word - 1) {
        const auto bit = static_cast<uint32_t>(std::countr_zero(word));
        const uint32_t x = left + bit % kTileSize, y = top + bit / kTileSize;
        if (x < width && y < height) pixels[size_t{y} * width + x] |= 1u << light;
      }
    }
}

PredictionError& PredictionError::operator+=(const PredictionError& other) {
  pixels += other.pixels;
  bits += other.bits;
  wrong += other.wrong;
  falsely_dark += other.falsely_dark;
  return *this;
}

PredictionError compare(const LightBits& seen, std::span<const uint32_t> sources, const PixelRect& traced,
                        const LightBits& fresh, std::span<const uint32_t> care, const PixelRect& shown) {
  PredictionError error;
  error.pixels = uint64_t{shown.width} * shown.height;
  for (uint32_t y = 0; y < shown.height; ++y)
    for (uint32_t x = 0; x < shown.width; ++x) {
      const size_t at = size_t{shown.top + y} * fresh.width + shown.left + x;
      const uint32_t source = sources[size_t{y} * shown.width + x];
      if (source == 0 && care.empty()) continue;
      const bool found = source != 0 && traced.contains((source - 1) % seen.width, (source - 1) / seen.width);
      const uint32_t matter = care.empty() ? fresh.all() : care[at];
      const uint32_t predicted = found ? seen.pixels[source - 1] : ~0u;
      const uint32_t wrong = (predicted ^ fresh.pixels[at]) & matter;
      error.bits += static_cast<uint64_t>(std::popcount(matter));
      error.wrong += static_cast<uint64_t>(std::popcount(wrong));
      error.falsely_dark += static_cast<uint64_t>(std::popcount(wrong & ~predicted));
    }
  return error;
}

PredictionError compare_some(const TileMaskView& seen, std::span<const uint32_t> sources, const TileMaskView& fresh,
                             const PixelRect& shown, uint32_t step, const LightPlanes& planes) {
  const LightPlanes of_lights =
      planes.light_count() > 0 ? planes : LightPlanes(std::vector<bool>(fresh.grid.planes), 1);
  PredictionError error;
  for (uint32_t y = 0; y < shown.height; y += step)
    for (uint32_t x = 0; x < shown.width; x += step) {
      ++error.pixels;
      const uint32_t source = sources[size_t{y} * shown.width + x];
      if (source == 0) continue;
      const uint32_t seen_x = (source - 1) % seen.grid.width, seen_y = (source - 1) / seen.grid.width;
      for (uint32_t light = 0; light < of_lights.light_count(); ++light) {
        const uint32_t said = of_lights.seen(seen, seen_x, seen_y, light);
        const uint32_t is = of_lights.seen(fresh, shown.left + x, shown.top + y, light);
        error.bits += of_lights.samples(light);
        error.wrong += std::max(said, is) - std::min(said, is);
        error.falsely_dark += is > said ? is - said : 0;
      }
    }
  return error;
}

}  // namespace gnomon::client
