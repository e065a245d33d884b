// Finds how finely a scene's light buffers may be divided within a budget: one threshold for all lights, so that memory
// and time go to those that gain most by it.
#pragma once

#include <map>

#include "gpu/tracers/light_buffer/light_build.h"

namespace gnomon::gpu::light_buffer {

// What light buffers take, detail by detail, as far as it was surveyed. A threshold is Detail::cost_per_byte.
class DetailSurvey {
 public:
  // No detail finer than `finest` is looked at.
  DetailSurvey(const Detail& finest, const PiecesSize& limit) : finest_(finest), limit_(limit) {}

  // Adds a light: surveys it, from coarse to fine, until it alone is beyond the limit.
  void add(const LightBuild& build);

  // The finest detail that is expected to be within the limit, or the coarsest of all.
  Detail fitting() const;
  // Of the light that was added as the l-th, as it is expected.
  uint64_t bytes(size_t l, const Detail& detail) const;

 private:
  // Thresholds, from the coarsest on; the last one is that of the finest detail.
  double threshold(size_t step) const;
  // At a place between two steps.
  PiecesSize at(size_t l, double step) const;
  PiecesSize of_all(double step) const;

  const Detail finest_;
  const PiecesSize limit_;
  std::vector<std::vector<PiecesSize>> lights_;  // step by step
};

}  // namespace gnomon::gpu::light_buffer
