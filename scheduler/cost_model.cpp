#include "scheduler/cost_model.h"

#include <algorithm>
#include <cmath>

namespace gnomon::scheduler {
namespace {

constexpr double kForget = 0.98;      // weight of a measurement relative to the next one: about 50 count
constexpr double kOutlier = 4;        // multiple of the usual error beyond which a measurement is an outlier
constexpr double kLeastError = 0.05;  // lower bound of the usual error, as a share of the prediction
constexpr uint64_t kTrusting = 8;     // measurements of a new size that no outlier test is applied to
constexpr double kGuessPerBit = 0.5;  // ns; between a GPU and a CPU

constexpr double kViewForget = 0.7;
constexpr double kViewRange = 4;  // a view's factor stays between 1 / kViewRange and kViewRange

double in_ns(Nanoseconds d) { return static_cast<double>(d.count()); }
Nanoseconds from_ns(double ns) { return Nanoseconds(static_cast<int64_t>(std::max(0.0, ns))); }

double mean(double old, double value, uint64_t measurements) {
  const double share = std::max(1 - kForget, 1.0 / static_cast<double>(measurements));
  return old + share * (value - old);
}

}  // namespace

// Whether the outlier test is skipped for this measurement: more than half as far again beyond the sizes measured so
// far, the line is an extrapolation, and the next kTrusting measurements are taken as they are.
bool RobustLine::believes(double x) {
  if (measurements_ == 0) least_x_ = most_x_ = x;
  const bool new_size = x > 1.5 * most_x_ || 1.5 * x < least_x_;
  least_x_ = std::min(least_x_, x);
  most_x_ = std::max(most_x_, x);
  if (new_size || measurements_ == 0) to_believe_ = kTrusting;
  if (to_believe_ == 0) return false;
  --to_believe_;
  return true;
}

void RobustLine::learn(double x, double y) {
  const bool believed = believes(x);
  const double off = y - at(x);
  const double usual = std::max(usual_error_, kLeastError * at(x));
  const bool outlier = !believed && std::abs(off) > kOutlier * usual;
  const double moved = outlier ? at(x) + std::copysign(kOutlier * usual, off) : y;
  ++measurements_;
  if (measurements_ > 1) usual_error_ = mean(usual_error_, std::abs(moved - at(x)), measurements_ - 1);
  n_ = kForget * n_ + 1;
  x_ = kForget * x_ + x;
  y_ = kForget * y_ + moved;
  xx_ = kForget * xx_ + x * x;
  xy_ = kForget * xy_ + x * moved;
  fit();
}

void RobustLine::fit() {
  const double spread = n_ * xx_ - x_ * x_;
  const double through_origin = xx_ > 0 ? xy_ / xx_ : 0;
  if (spread < 0.01 * n_ * xx_) {  // sizes that hardly differ do not determine the constant
    slope_ = std::max(0.0, through_origin);
    constant_ = xx_ > 0 ? 0 : y_ / n_;
    return;
  }
  slope_ = (n_ * xy_ - x_ * y_) / spread;
  constant_ = (y_ - slope_ * x_) / n_;
  if (slope_ < 0) {
    slope_ = 0;
    constant_ = y_ / n_;
  } else if (constant_ < 0) {
    constant_ = 0;
    slope_ = through_origin;
  }
}

Cost CostModel::predict(const Work& work) const {
  const double bits = static_cast<double>(work.bits);
  if (!knows()) return {{}, from_ns(kGuessPerBit * bits)};
  const double begin = work.begins ? begin_.at(static_cast<double>(work.pixels)) : 0;
  return {from_ns(begin), from_ns(trace_.at(bits))};
}

Cost CostModel::predict_within_reach(const Work& work) const {
  if (!knows()) return predict(work);
  const double begin = work.begins ? begin_.within_reach(static_cast<double>(work.pixels)) : 0;
  return {from_ns(begin), from_ns(trace_.within_reach(static_cast<double>(work.bits)))};
}

void CostModel::learn(const Work& work, Nanoseconds gpu_time, Nanoseconds trace) {
  if (gpu_time <= Nanoseconds{}) return;
  const double error = std::abs(in_ns(predict(work).total() - gpu_time)) / in_ns(gpu_time);
  if (knows()) relative_error_ = mean(relative_error_, error, ++measurements_);
  trace_.learn(static_cast<double>(work.bits), in_ns(trace));
  if (work.begins) begin_.learn(static_cast<double>(work.pixels), in_ns(gpu_time - trace));
}

void CostModel::learn_bytes(uint64_t bits, size_t bytes) {
  if (bits < kTellingBits) return;
  bytes_per_bit_ = mean(bytes_per_bit_, static_cast<double>(bytes) / static_cast<double>(bits), ++frames_sent_);
}

Nanoseconds CostModel::constant() const {
  return Nanoseconds(static_cast<int64_t>(begin_.constant() + trace_.constant()));
}

Nanoseconds ViewFactor::apply(const Cost& predicted) const {
  return std::max(Nanoseconds(1), from_ns(begin_ * in_ns(predicted.begin) + trace_ * in_ns(predicted.trace)));
}

void ViewFactor::learn(const Cost& predicted_by_model, const Cost& real) {
  // A part below a tenth of the job's cost is too small to be measured reliably.
  const Nanoseconds least = predicted_by_model.total() / 10;
  const auto follow = [least](double& factor, Nanoseconds predicted, Nanoseconds measured) {
    if (predicted <= least) return;
    const double ratio = std::clamp(in_ns(measured) / in_ns(predicted), 1 / kViewRange, kViewRange);
    factor = kViewForget * factor + (1 - kViewForget) * ratio;
  };
  follow(begin_, predicted_by_model.begin, real.begin);
  follow(trace_, predicted_by_model.trace, real.trace);
}

}  // namespace gnomon::scheduler
