// Predicts what a job will cost, in device time and in bytes on the wire, from measurements of earlier jobs. There is
// one model for each device, scene, tracer and number of samples (scheduler/sample_costs.h). The caller serialises all calls.
//
//   cost = (constant + per pixel * pixels of the frame, for the job that begins it)
//        + (constant + per bit * visibility bits that the job traces)
//
// Both parts are lines fitted by least squares with exponential forgetting. The residual of an outlier is clipped, as
// in Huber's M-estimator ("Robust Estimation of a Location Parameter", 1964): a frame that a busy machine delayed
// hardly moves the line, while a real change is learned within some tens of frames. The first measurements of a size
// that is new to the line are not clipped. What frames of 8x8 pixels cost says nothing of large ones: jobs are cut and
// charged by the line all the same, but nobody is refused for it.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "common/clock.h"
#include "scheduler/worst_rate.h"

namespace gnomon::scheduler {

// One job: a frame, or a band of one.
struct Work {
  uint64_t pixels = 0;  // of the complete frame
  uint64_t bits = 0;    // pixels x lights that this job traces, as weighted_bits() counts them
  bool begins = true;   // the job contains the frame's first band
};

// A line fitted to measurements. It passes through the origin while the measurements hardly differ in x, and is not
// negative for any x >= 0.
class RobustLine {
 public:
  static constexpr double kReach = 8;

  double at(double x) const { return constant_ + slope_ * x; }
  // The same, but no more than at kReach times what x usually was of late (its root mean square).
  double within_reach(double x) const { return at(n_ > 0 ? std::min(x, kReach * std::sqrt(xx_ / n_)) : x); }
  void learn(double x, double y);
  bool knows() const { return measurements_ > 0; }
  double constant() const { return constant_; }
  double slope() const { return slope_; }

 private:
  void fit();
  bool believes(double x);

  uint64_t measurements_ = 0;
  uint64_t to_believe_ = 0;          // further measurements to take without the outlier test
  double least_x_ = 0, most_x_ = 0;  // the range of x measured so far
  double constant_ = 0, slope_ = 0;
  double usual_error_ = 0;                          // mean of |y - line|, with forgetting
  double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0;  // sums, with forgetting
};

// Device time of one job: the part that begins the frame (rasterisation), and the part that grows with the bits.
struct Cost {
  Nanoseconds begin{}, trace{};

  Nanoseconds total() const { return begin + trace; }
};

class CostModel {
 public:
  // Before the first measurement this is a guess of 0.5 ns per bit, so that the first job is charged something.
  Cost predict(const Work& work) const;

  // What it surely costs at least: no more than jobs of kReach times the sizes of late. By this sessions are admitted.
  Cost predict_within_reach(const Work& work) const;

  // `trace`: the part of `gpu_time` that grows with the bits. Ignored if `gpu_time` is 0.
  void learn(const Work& work, Nanoseconds gpu_time, Nanoseconds trace);

  // What bits cost at worst, whatever predict() says of those of late.
  WorstRate& worst() { return worst_; }
  const WorstRate& worst() const { return worst_; }

  // What smaller frames take on the wire is their headers.
  static constexpr uint64_t kTellingBits = 1 << 14;

  // The encoded size of a complete frame of so many bits; 0 before the first call of learn_bytes.
  double predict_bytes(uint64_t bits) const { return bytes_per_bit_ * static_cast<double>(bits); }
  void learn_bytes(uint64_t bits, size_t bytes);

  bool knows() const { return trace_.knows(); }
  double ns_per_bit() const { return trace_.slope(); }
  Nanoseconds constant() const;                              // the part that depends on neither pixels nor bits
  double relative_error() const { return relative_error_; }  // mean of |predicted - real| / real, with forgetting

 private:
  RobustLine begin_, trace_;
  WorstRate worst_;
  double relative_error_ = 0;
  uint64_t measurements_ = 0;
  double bytes_per_bit_ = 0;
  uint64_t frames_sent_ = 0;
};

// The ratio of one session's costs to the model's predictions: what its camera shows may be dearer or cheaper to
// rasterise and to trace than what others see, and changes slowly.
class ViewFactor {
 public:
  Nanoseconds apply(const Cost& predicted) const;
  void learn(const Cost& predicted_by_model, const Cost& real);

 private:
  double begin_ = 1, trace_ = 1;
};

}  // namespace gnomon::scheduler
