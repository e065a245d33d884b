#include "scheduler/degradation.h"

#include <algorithm>
#include <cmath>

namespace gnomon::scheduler {
namespace {

constexpr uint32_t kFewestViews = 4;  // a window with fewer views is not evaluated
constexpr double kBad = 0.8;          // a window is bad if a smaller share of its views was answered
constexpr double kGood = 0.95;        // a window is good if at least this share was answered

constexpr uint32_t kBadWindows = 2;
constexpr uint32_t kGoodWindows = 5;
constexpr uint32_t kMostPatience = 160;
constexpr uint32_t kProven = 30;  // windows after which a step up counts as successful

constexpr double kRateStep = 0.75, kSizeStep = 0.75, kLightStep = 0.75;
constexpr uint32_t kSampleStep = 4;

// The number of steps by `factor` that stay at `least` or above.
uint32_t steps(double factor, double least) {
  return least >= 1 ? 0 : static_cast<uint32_t>(std::log(std::max(least, 0.01)) / std::log(factor) + 1e-9);
}

// One step below `now`; the same if there is none.
SampleCounts fewer(SampleCounts now, uint32_t least_per_light) {
  const uint32_t points = now.per_light / kSampleStep;
  if (points >= std::max(1u, least_per_light)) return {points, now.occlusion};
  if (now.occlusion == Occlusion::none) return now;
  return {now.per_light, now.occlusion == Occlusion::full ? Occlusion::half : Occlusion::none};
}

}  // namespace

void Degradation::set_limits(const DegradationLimits& limits, SampleCounts samples) {
  limits_ = limits;
  samples_ = samples;
  level_ = std::min(level_, deepest());
}

bool Degradation::observe(const ServiceWindow& window) {
  if (since_step_up_ > 0 && ++since_step_up_ > kProven) {
    since_step_up_ = 0;
    patience_ = 0;
  }
  if (window.offered < kFewestViews) return false;
  const double answered = window.answered + 1;  // one frame may be in flight
  bad_ = answered < kBad * window.offered ? bad_ + 1 : 0;
  good_ = answered >= kGood * window.offered ? good_ + 1 : 0;
  if (bad_ >= kBadWindows) return down();
  if (level_ > 0 && good_ >= kGoodWindows + patience_) return up();
  return false;
}

bool Degradation::down() {
  bad_ = 0;
  if (since_step_up_ > 0) patience_ = std::clamp(2 * patience_, kGoodWindows, kMostPatience);
  since_step_up_ = 0;
  if (level_ >= deepest()) return false;
  ++level_;
  return true;
}

bool Degradation::up() {
  good_ = 0;
  since_step_up_ = 1;
  --level_;
  return true;
}

uint32_t Degradation::sample_steps() const {
  uint32_t steps = 0;
  for (SampleCounts at = samples_, below; (below = fewer(at, limits_.least_samples)) != at; at = below) ++steps;
  return steps;
}

SampleCounts Degradation::samples() const {
  SampleCounts at = samples_;
  for (uint32_t step = point().fewer_samples; step > 0; --step) at = fewer(at, limits_.least_samples);
  return at;
}

uint32_t Degradation::deepest() const {
  return steps(kRateStep, limits_.least_rate) + sample_steps() + steps(kSizeStep, limits_.least_size) +
         steps(kLightStep, limits_.least_lights);
}

OperatingPoint Degradation::point() const {
  const uint32_t by_rate = std::min(level_, steps(kRateStep, limits_.least_rate));
  const uint32_t by_samples = std::min(level_ - by_rate, sample_steps());
  const uint32_t by_size = std::min(level_ - by_rate - by_samples, steps(kSizeStep, limits_.least_size));
  const uint32_t by_lights =
      std::min(level_ - by_rate - by_samples - by_size, steps(kLightStep, limits_.least_lights));
  return {std::pow(kRateStep, by_rate), std::pow(kSizeStep, by_size), std::pow(kLightStep, by_lights), by_samples};
}

}  // namespace gnomon::scheduler
