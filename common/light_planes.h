// Which planes of a mask belong to which light, where lights are seen from several points (soft shadows).
//
// A light that is traced by one segment has one plane: its bit. An area light of which k sample points are traced
// (k: 4 or 16) has 1 + log2(k) planes that together say how many of them the surface sees:
//   the first        1 if it sees all k; the planes below then do not matter ("care", common/packed_mask.h);
//   the others       the bits of the number that it sees, the most significant first.
// So tiles that are lit or dark throughout stay uniform in every plane, and only penumbrae take bytes.
#pragma once

#include <bit>
#include <cassert>
#include <cstdint>
#include <vector>

#include "common/tile_mask.h"

namespace gnomon {

// The sample points of an area light that one pixel asks for: 1 (the light's middle, as hard shadows), 4 or 16.
constexpr bool is_sample_count(uint32_t samples) { return samples == 1 || samples == 4 || samples == 16; }
inline constexpr uint32_t kMostSamples = 16;

constexpr uint32_t planes_of(uint32_t samples) { return static_cast<uint32_t>(std::bit_width(samples)); }

class LightPlanes {
 public:
  LightPlanes() = default;
  // `is_area`: for each light, in order. `samples`: of each area light; every other light has one.
  LightPlanes(const std::vector<bool>& is_area, uint32_t samples) {
    assert(is_sample_count(samples));
    for (const bool area : is_area) {
      const uint32_t of_light = area ? samples : 1;
      lights_.push_back({total_, of_light});
      total_ += planes_of(of_light);
    }
  }

  uint32_t light_count() const { return static_cast<uint32_t>(lights_.size()); }
  uint32_t total() const { return total_; }
  uint32_t first(uint32_t light) const { return lights_[light].first; }
  uint32_t samples(uint32_t light) const { return lights_[light].samples; }
  uint32_t count(uint32_t light) const { return planes_of(samples(light)); }
  bool is_hard() const { return total_ == lights_.size(); }

  // How many of the light's sample points pixel (x, y) sees, 0 to samples(light). `mask` has total() planes.
  uint32_t seen(const TileMaskView& mask, uint32_t x, uint32_t y, uint32_t light) const {
    const uint32_t plane = first(light), all = samples(light);
    if (mask.lit(x, y, plane)) return all;
    uint32_t number = 0;
    for (uint32_t i = 1; i < planes_of(all); ++i) number = 2 * number + (mask.lit(x, y, plane + i) ? 1 : 0);
    return number;
  }

  friend bool operator==(const LightPlanes&, const LightPlanes&) = default;

 private:
  struct OfLight {
    uint32_t first = 0;
    uint32_t samples = 1;
    friend bool operator==(const OfLight&, const OfLight&) = default;
  };
  std::vector<OfLight> lights_;
  uint32_t total_ = 0;
};

}  // namespace gnomon
