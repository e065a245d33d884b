// Finds how finely a scene's light buffers may be divided within a budget: one threshold for all lights, so that memory
// and time go to those that gain most by it.
#pragma once

#include <vector>

#include "gpu/tracers/light_buffer/light_build.h"

namespace gnomon::gpu::light_buffer {

// What light buffers are expected to take at each of several details, and how finely they may be divided for it. A
// threshold is Detail::cost_per_byte.
class DetailSurvey {
 public:
  // No detail finer than `finest` is looked at. `limit`: of all lights.
  DetailSurvey(const Detail& finest, const PiecesSize& limit);

  // Adds a light: surveys it, as finely as the lights up to this one are expected to be within the limit.
  void add(const LightBuild& build);

  // The finest detail at which the lights from the l-th on are expected to be within the limit, or the coarsest of all.
  Detail fitting(size_t l, const PiecesSize& limit) const;
  // Of the light that was added as the l-th, as it is expected.
  uint64_t bytes(size_t l, const Detail& detail) const;

 private:
  // At a place between two steps.
  PiecesSize at(size_t l, double step) const;
  PiecesSize from(size_t l, double step) const;

  const Detail finest_;
  const PiecesSize limit_;
  std::vector<double> thresholds_;  // of the steps, from the coarsest on; the last is the finest detail's
  std::vector<std::vector<PiecesSize>> lights_;  // step by step
};

}  // namespace gnomon::gpu::light_buffer
