// What frames of one scene cost on one device, by the sample points of its area lights that they trace
// (common/light_planes.h). The caller serialises all calls.
//
// Points of one light share most of their work: 16 of them cost a device far less than 16 hard shadows. How much less
// depends on scene, tracer and device, so that each number of samples has a model of its own. Until it has measured
// something, the model of another number stands in for it: area_weight() is then what tells the two apart.
#pragma once

#include <array>
#include <cstdint>

#include "common/light_planes.h"
#include "scheduler/cost_model.h"

namespace gnomon::scheduler {

// As how many visibility bits of a light without extent an area light counts at a pixel, in rates, limits and
// predictions. Measurements correct the predictions.
constexpr double area_weight(uint32_t samples) { return samples >= 16 ? 2.5 : samples >= 4 ? 1.5 : 1; }

// The visibility bits of so many pixels of which `lights` are traced, `areas` of them with that many samples.
constexpr uint64_t weighted_bits(uint64_t pixels, uint32_t lights, uint32_t areas, uint32_t samples) {
  return pixels * lights + static_cast<uint64_t>((area_weight(samples) - 1) * static_cast<double>(pixels * areas));
}

class SampleCosts {
 public:
  // Of frames with that many samples; while nothing is known of them, of the next fewer ones of which something is, else
  // of the next more.
  const CostModel& model(uint32_t samples) const {
    const size_t own = index(samples);
    for (size_t i = own + 1; i-- > 0;)
      if (models_[i].knows()) return models_[i];
    for (size_t i = own + 1; i < models_.size(); ++i)
      if (models_[i].knows()) return models_[i];
    return models_[own];
  }
  // Of frames with that many samples alone, to learn from them.
  CostModel& of(uint32_t samples) { return models_[index(samples)]; }

 private:
  static constexpr size_t index(uint32_t samples) { return samples >= 16 ? 2 : samples >= 4 ? 1 : 0; }

  std::array<CostModel, 3> models_;  // of 1, 4 and 16
};

}  // namespace gnomon::scheduler
