// How far ahead of the newest masks to show: the dissertation's x. Policies; no clock, no locks.
//
//   FixedAhead  x is a number (3.3)
//   Switching   the dissertation's switching between x as large as can be and none (3.5): client/prediction/switching.h
//   Balance     the x of least expected error plus response time's cost: client/prediction/balance.h
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>

#include "common/clock.h"
#include "protocol/types.h"

namespace gnomon::client {

inline constexpr size_t kMostAhead = 19;  // as the dissertation measured

// A camera that was asked for.
struct AskedCamera {
  uint32_t index = 0;  // counts up
  protocol::CameraView camera;
  TimePoint asked{};
};

struct AheadChoice {
  const std::deque<AskedCamera>& cameras;  // front: the newest whose masks have come; back: that of this moment
  size_t least = 0;                        // of them: what was shown last; pictures do not go back
  Nanoseconds latency{};                   // from asking for the front one to its masks' arrival
  TimePoint now{};

  size_t most() const { return std::max(least, std::min(cameras.size() - 1, kMostAhead)); }
};

class Ahead {
 public:
  virtual ~Ahead() = default;

  // Which of the cameras to show, from `least` to `most()`. Called once for each frame shown.
  virtual size_t choose(const AheadChoice& choice) = 0;

  // What a prediction turned out to be, once the masks of its camera have come: `error`, the share of wrong bits of
  // `later` as predicted from `earlier`.
  virtual void observe(const protocol::CameraView& /*earlier*/, const protocol::CameraView& /*later*/,
                       double /*error*/) {}
};

class FixedAhead : public Ahead {
 public:
  explicit FixedAhead(size_t x) : x_(x) {}
  size_t choose(const AheadChoice& choice) override { return std::clamp(x_, choice.least, choice.most()); }

 private:
  size_t x_;
};

}  // namespace gnomon::client
