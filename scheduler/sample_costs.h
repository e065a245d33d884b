// What frames of one scene cost on one device, by the samples that they trace (common/sample_counts.h). The caller
// serialises all calls.
//
// Points of one light share most of their work: 16 of them cost a device far less than 16 hard shadows. How much less
// depends on scene, tracer and device, so that frames of each kind have a model of their own. Until it has measured
// something, the model of another kind stands in for it: the weights below are then what tells the two apart.
#pragma once

#include <array>
#include <cstdint>

#include "common/sample_counts.h"
#include "scheduler/cost_model.h"

namespace gnomon::scheduler {

// As how many visibility bits of a light without extent an area light counts at a pixel, in rates, limits and
// predictions. Measurements correct the predictions.
constexpr double area_weight(uint32_t samples) { return samples >= 16 ? 2.5 : samples >= 4 ? 1.5 : 1; }
// As how many of them the occlusion of a pixel's ambient light counts.
constexpr double occlusion_weight(Occlusion occlusion) {
  return occlusion == Occlusion::none ? 0 : occlusion == Occlusion::half ? 1 : 3;
}

// The visibility bits of so many pixels of which `lights` are traced, `areas` of them lights with an extent.
constexpr uint64_t weighted_bits(uint64_t pixels, uint32_t lights, uint32_t areas, SampleCounts samples) {
  const double more = (area_weight(samples.per_light) - 1) * areas + occlusion_weight(samples.occlusion);
  return pixels * lights + static_cast<uint64_t>(more * static_cast<double>(pixels));
}

class SampleCosts {
 public:
  // Of frames with these samples; while nothing is known of them, of the next fewer ones of which something is, else of
  // the next more.
  const CostModel& model(SampleCounts samples) const {
    const size_t own = index(samples);
    for (size_t i = own + 1; i-- > 0;)
      if (models_[i].knows()) return models_[i];
    for (size_t i = own + 1; i < models_.size(); ++i)
      if (models_[i].knows()) return models_[i];
    return models_[own];
  }
  // Of frames with these samples alone, to learn from them.
  CostModel& of(SampleCounts samples) { return models_[index(samples)]; }

  // So many bits of a frame with these samples are traced within `limit`, whatever its view, as far as one knows; no more
  // than kMostHardBits, or `most_soft_bits` with points or occlusion, whose cost differs by orders of magnitude.
  uint64_t bits_within(SampleCounts samples, Nanoseconds limit, uint64_t most_soft_bits) const {
    const uint64_t most = index(samples) == 0 ? kMostHardBits : most_soft_bits;
    return models_[index(samples)].worst().bits_within(limit, most);
  }
  static constexpr uint64_t kMostHardBits = uint64_t{1} << 25;  // 1920x1080 under 16 lights

 private:
  // In the order of what they are expected to cost.
  static constexpr size_t index(SampleCounts samples) {
    const size_t points = samples.per_light >= 16 ? 2 : samples.per_light >= 4 ? 1 : 0;
    return 3 * points + static_cast<size_t>(samples.occlusion);
  }

  std::array<CostModel, 9> models_;
};

}  // namespace gnomon::scheduler
