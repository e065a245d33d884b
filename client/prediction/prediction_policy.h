// Policies that choose how many frames ahead of the newest masks to show: the dissertation's x. No clock, no locks.
//
//   FixedPrediction  x is a number (3.3)
//   Switching   the dissertation's switching between the largest possible x and none (3.5): switching.h
//   ErrorBalance     the x with the least sum of expected error and cost of response time: error_balance.h
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>

#include "common/clock.h"
#include "protocol/types.h"

namespace gnomon::client {

inline constexpr size_t kMostAhead = 19;  // the largest x that the dissertation measured

// A camera that was asked for.
struct RequestedCamera {
  uint32_t index = 0;  // counts up
  protocol::CameraView camera;
  TimePoint asked{};
};

struct PredictionChoice {
  const std::deque<RequestedCamera>& cameras;  // front: the newest with masks; back: the newest
  size_t least = 0;                            // index of the one shown last: pictures never go back
  Nanoseconds latency{};                       // from asking for the front one to its masks' arrival
  TimePoint now{};

  size_t most() const { return std::max(least, std::min(cameras.size() - 1, kMostAhead)); }
};

class PredictionPolicy {
 public:
  virtual ~PredictionPolicy() = default;

  // The index of the camera to show, from `least` to `most()`. Called once for each frame shown.
  virtual size_t choose(const PredictionChoice& choice) = 0;

  // Reports how wrong a prediction was, once the masks of its camera have arrived: `error` is the share of wrong bits
  // in the masks of `later` as predicted from those of `earlier`.
  virtual void observe(const protocol::CameraView& /*earlier*/, const protocol::CameraView& /*later*/,
                       double /*error*/) {}
};

class FixedPrediction : public PredictionPolicy {
 public:
  explicit FixedPrediction(size_t x) : x_(x) {}
  size_t choose(const PredictionChoice& choice) override { return std::clamp(x_, choice.least, choice.most()); }

 private:
  size_t x_;
};

}  // namespace gnomon::client
