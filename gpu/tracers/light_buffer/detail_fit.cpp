#include "gpu/tracers/light_buffer/detail_fit.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gnomon::gpu::light_buffer {
namespace {

constexpr double kCoarsest = 1e-2, kRatio = std::numbers::sqrt2;  // thresholds of the survey
constexpr double kBeyond = 1.4;  // the limit: what is surveyed, as lights that take less leave more to later ones
constexpr double kFill = 0.97;   // of the limit: what is expected is an estimate

uint64_t between(uint64_t low, uint64_t high, double share) {
  const double a = std::log(static_cast<double>(low) + 1), b = std::log(static_cast<double>(high) + 1);
  return static_cast<uint64_t>(std::exp(a + share * (b - a)));
}

}  // namespace

DetailSurvey::DetailSurvey(const Detail& finest, const PiecesSize& limit) : finest_(finest), limit_(limit) {
  const double last = std::max(finest.cost_per_byte, 1e-30);
  double threshold = kCoarsest;
  while (threshold > last) {
    thresholds_.push_back(threshold);
    threshold /= kRatio;
  }
  thresholds_.push_back(last);
}

void DetailSurvey::add(const LightBuild& build) {
  const PiecesSize limit = limit_.times(kBeyond);
  std::vector<PiecesSize> limits;
  for (size_t s = 0; s < (lights_.empty() ? thresholds_.size() : lights_.back().size()); ++s)
    limits.push_back(limit.less(from(0, static_cast<double>(s))));
  lights_.push_back(build.expected_sizes(thresholds_, finest_.finest_level, limits));
}

PiecesSize DetailSurvey::at(size_t l, double step) const {
  const std::vector<PiecesSize>& steps = lights_[l];
  const size_t low = std::min(static_cast<size_t>(step), steps.size() - 1);
  const size_t high = std::min(low + 1, steps.size() - 1);
  const double share = step - std::floor(step);
  return {between(steps[low].bytes, steps[high].bytes, share), between(steps[low].work, steps[high].work, share)};
}

PiecesSize DetailSurvey::from(size_t l, double step) const {
  PiecesSize sum;
  for (; l < lights_.size(); ++l) {
    const PiecesSize one = at(l, step);
    sum.bytes += one.bytes;
    sum.work += one.work;
  }
  return sum;
}

uint64_t DetailSurvey::bytes(size_t l, const Detail& detail) const {
  return at(l, std::max(0.0, std::log(kCoarsest / detail.cost_per_byte) / std::log(kRatio))).bytes;
}

Detail DetailSurvey::fitting(size_t l, const PiecesSize& limit) const {
  Detail detail = finest_;
  if (l >= lights_.size()) return detail;
  const PiecesSize filled{static_cast<uint64_t>(kFill * static_cast<double>(limit.bytes)), limit.work};
  double step = static_cast<double>(lights_.back().size() - 1);  // the finest that every light was surveyed at
  constexpr double kPart = 1.0 / 8;
  while (step > 0 && !from(l, step).within(filled)) step -= kPart;
  const auto whole = static_cast<size_t>(step);
  const double coarse = thresholds_[whole], fine = thresholds_[std::min(whole + 1, thresholds_.size() - 1)];
  detail.cost_per_byte = coarse * std::pow(fine / coarse, step - static_cast<double>(whole));
  return detail;
}

}  // namespace gnomon::gpu::light_buffer
