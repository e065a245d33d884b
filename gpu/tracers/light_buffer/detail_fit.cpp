#include "gpu/tracers/light_buffer/detail_fit.h"

#include <algorithm>
#include <cmath>

namespace gnomon::gpu::light_buffer {
namespace {

constexpr double kCoarsest = 1e-2, kRatio = 8.0;  // thresholds of the survey
constexpr double kFill = 0.97;                    // of the limit: what is expected is an estimate

bool within(const PiecesSize& size, const PiecesSize& limit) {
  return size.bytes <= limit.bytes && size.work <= limit.work;
}

uint64_t between(uint64_t low, uint64_t high, double share) {
  const double a = std::log(static_cast<double>(low) + 1), b = std::log(static_cast<double>(high) + 1);
  return static_cast<uint64_t>(std::exp(a + share * (b - a)));
}

}  // namespace

double DetailSurvey::threshold(size_t step) const {
  return std::max(kCoarsest * std::pow(kRatio, -static_cast<double>(step)), std::max(finest_.cost_per_byte, 1e-30));
}

void DetailSurvey::add(const LightBuild& build) {
  std::vector<PiecesSize>& steps = lights_.emplace_back();
  do {
    Detail detail = finest_;
    detail.cost_per_byte = threshold(steps.size());
    steps.push_back(build.expected_size(detail));
  } while (within(steps.back(), limit_) && threshold(steps.size() - 1) > finest_.cost_per_byte && !build.stopped());
}

PiecesSize DetailSurvey::at(size_t l, double step) const {
  const std::vector<PiecesSize>& steps = lights_[l];
  const size_t low = std::min(static_cast<size_t>(step), steps.size() - 1);
  const size_t high = std::min(low + 1, steps.size() - 1);
  const double share = step - std::floor(step);
  return {between(steps[low].bytes, steps[high].bytes, share), between(steps[low].work, steps[high].work, share)};
}

PiecesSize DetailSurvey::of_all(double step) const {
  PiecesSize sum;
  for (size_t l = 0; l < lights_.size(); ++l) {
    const PiecesSize one = at(l, step);
    sum.bytes += one.bytes;
    sum.work += one.work;
  }
  return sum;
}

uint64_t DetailSurvey::bytes(size_t l, const Detail& detail) const {
  return at(l, std::max(0.0, std::log(kCoarsest / detail.cost_per_byte) / std::log(kRatio))).bytes;
}

Detail DetailSurvey::fitting() const {
  size_t last = lights_.empty() ? 0 : SIZE_MAX;  // the finest step that every light was surveyed at
  for (const std::vector<PiecesSize>& steps : lights_) last = std::min(last, steps.size() - 1);
  const PiecesSize filled{static_cast<uint64_t>(kFill * static_cast<double>(limit_.bytes)), limit_.work};
  double step = static_cast<double>(last);
  constexpr double kPart = 1.0 / 16;
  while (step > 0 && !within(of_all(step), filled)) step -= kPart;
  Detail detail = finest_;
  const double whole = std::floor(step);
  const double coarse = threshold(static_cast<size_t>(whole)), fine = threshold(static_cast<size_t>(whole) + 1);
  detail.cost_per_byte = coarse * std::pow(fine / coarse, step - whole);
  return detail;
}

}  // namespace gnomon::gpu::light_buffer
