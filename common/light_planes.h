// Which planes of a mask belong to which light, where lights are seen from several points (soft shadows).
//
// A light that is traced by one segment has one plane: its bit. An area light of which k sample points are traced
// (k: 4 or 16) has 1 + log2(k) planes that together say how many of them the surface sees:
//   the first        1 if it sees all k; the planes below then do not matter ("care", common/packed_mask.h);
//   the others       the bits of the number that it sees, the most significant first.
// So tiles that are lit or dark throughout stay uniform in every plane, and only penumbrae take bytes.
//
// Behind the planes of the lights stand those of the ambient light's occlusion, if the frame has it: of the number of
// segments, of kOcclusionSegments, that nothing near blocks. In the same way, so that surfaces in the open are uniform.
#pragma once

#include <cassert>
#include <cstdint>
#include <vector>

#include "common/sample_counts.h"
#include "common/tile_mask.h"

namespace gnomon {

class LightPlanes {
 public:
  LightPlanes() = default;
  // `is_area`: for each light, in order; every other light has one sample.
  LightPlanes(const std::vector<bool>& is_area, SampleCounts samples) : occlusion_(samples.occlusion) {
    assert(is_valid(samples));
    for (const bool area : is_area) {
      const uint32_t of_light = area ? samples.per_light : 1;
      lights_.push_back({of_lights_, of_light});
      of_lights_ += planes_of(of_light);
    }
  }

  uint32_t light_count() const { return static_cast<uint32_t>(lights_.size()); }
  uint32_t total() const { return of_lights_ + planes_of(occlusion_); }
  uint32_t first(uint32_t light) const { return lights_[light].first; }
  uint32_t samples(uint32_t light) const { return lights_[light].samples; }
  uint32_t count(uint32_t light) const { return planes_of(samples(light)); }
  bool is_hard() const { return total() == lights_.size(); }
  Occlusion occlusion() const { return occlusion_; }
  uint32_t first_of_occlusion() const { return of_lights_; }  // meaningless without any

  // How many of the light's sample points pixel (x, y) sees, 0 to samples(light). `mask` has total() planes.
  uint32_t seen(const TileMaskView& mask, uint32_t x, uint32_t y, uint32_t light) const {
    return number(mask, x, y, first(light), samples(light));
  }
  // How many of kOcclusionSegments nothing near blocks. Precondition: the mask has occlusion(), and of pixel (x, y).
  uint32_t open_segments(const TileMaskView& mask, uint32_t x, uint32_t y) const {
    return number(mask, x, y, first_of_occlusion(), kOcclusionSegments);
  }
  // Whether a pixel has an occlusion of its own.
  bool counts_occlusion(uint32_t x, uint32_t y) const {
    return occlusion_ == Occlusion::full || (occlusion_ == Occlusion::half && ((x | y) & 1) == 0);
  }

  friend bool operator==(const LightPlanes&, const LightPlanes&) = default;

 private:
  static uint32_t number(const TileMaskView& mask, uint32_t x, uint32_t y, uint32_t first_plane, uint32_t most) {
    if (mask.lit(x, y, first_plane)) return most;
    uint32_t bits = 0;
    for (uint32_t i = 1; i < planes_of(most); ++i) bits = 2 * bits + (mask.lit(x, y, first_plane + i) ? 1 : 0);
    return bits;
  }

  struct OfLight {
    uint32_t first = 0;
    uint32_t samples = 1;
    friend bool operator==(const OfLight&, const OfLight&) = default;
  };
  std::vector<OfLight> lights_;
  uint32_t of_lights_ = 0;  // planes
  Occlusion occlusion_ = Occlusion::none;
};

}  // namespace gnomon
