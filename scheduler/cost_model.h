// What a job will cost, learned from what jobs did cost: device time, and bytes on the wire. One model for each
// device, scene and tracer.
//
//   cost = (constant + per pixel * pixels of the frame, for the job that begins it)
//        + (constant + per bit * visibility bits that the job traces)
//
// Both parts are lines fitted by least squares with forgetting. A measurement far off the line moves it no more than
// one at the edge of the usual (Huber): a frame that a busy machine held up teaches little, a real change is learned
// within some tens of frames. The first ones of a size that the line has not met are believed as they are.
#pragma once

#include <cstdint>

#include "common/clock.h"

namespace gnomon::scheduler {

struct Work {
  uint64_t pixels = 0;  // of the whole frame
  uint64_t bits = 0;    // pixels x lights that this job traces
  bool begins = true;   // the frame: its first band, or all of it
};

// A line through measurements, from the origin while they are all alike. Not negative anywhere.
class RobustLine {
 public:
  double at(double x) const { return constant_ + slope_ * x; }
  void learn(double x, double y);
  bool knows() const { return measurements_ > 0; }
  double constant() const { return constant_; }
  double slope() const { return slope_; }

 private:
  void fit();
  bool believes(double x);

  uint64_t measurements_ = 0;
  uint64_t to_believe_ = 0;          // further ones, as they are
  double least_x_ = 0, most_x_ = 0;  // met so far
  double constant_ = 0, slope_ = 0;
  double usual_error_ = 0;                          // mean of |y - line|, forgetting
  double n_ = 0, x_ = 0, y_ = 0, xx_ = 0, xy_ = 0;  // sums, forgetting
};

// Of one job.
struct Cost {
  Nanoseconds begin{}, trace{};

  Nanoseconds total() const { return begin + trace; }
};

class CostModel {
 public:
  // Before anything was measured: a guess, so that the first job is neither free nor a flood.
  Cost predict(const Work& work) const;

  // `trace`: the part of `gpu_time` that depends on the bits.
  void learn(const Work& work, Nanoseconds gpu_time, Nanoseconds trace);

  // Of whole frames; 0 before one was sent.
  double predict_bytes(uint64_t bits) const { return bytes_per_bit_ * static_cast<double>(bits); }
  void learn_bytes(uint64_t bits, size_t bytes);

  bool knows() const { return trace_.knows(); }
  double ns_per_bit() const { return trace_.slope(); }
  Nanoseconds constant() const;                              // of a frame, its pixels aside
  double relative_error() const { return relative_error_; }  // mean of |predicted - real| / real, forgetting

 private:
  RobustLine begin_, trace_;
  double relative_error_ = 0;
  uint64_t measurements_ = 0;
  double bytes_per_bit_ = 0;
  uint64_t frames_sent_ = 0;
};

// How one session's frames differ from the model's: what its camera shows costs more or less than others see, to
// rasterise and to trace, and changes slowly.
class ViewFactor {
 public:
  Nanoseconds apply(const Cost& predicted) const;
  void learn(const Cost& predicted_by_model, const Cost& real);

 private:
  double begin_ = 1, trace_ = 1;
};

}  // namespace gnomon::scheduler
