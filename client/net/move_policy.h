// When a client whose server drains asks the door of its fleet for another session. See protocol/WIRE.md, Moving. Sends
// nothing and reads no clock. One thread.
#pragma once

#include <algorithm>
#include <optional>
#include <random>

#include "common/clock.h"
#include "protocol/messages.h"

namespace gnomon::client {

class MovePolicy {
 public:
  explicit MovePolicy(uint32_t seed = std::random_device{}()) : random_(seed) {}

  // The server has said that it drains. Returns for how long to wait before the door is asked; nullopt if nothing is to
  // be begun: the server does not ask for it, has taken it back, or has said it before.
  std::optional<Nanoseconds> told(const protocol::Draining& draining) {
    const bool begins = draining.move_now() && !wanted_;
    wanted_ = draining.move_now();
    if (!begins) return std::nullopt;
    retry_ = kFirstRetry;
    const std::chrono::milliseconds deadline(draining.deadline_ms);
    return spread(Nanoseconds::zero(), std::min<Nanoseconds>(kLongestSpread, deadline / 10));
  }

  // An attempt has failed, by the server's refusal or otherwise. Returns for how long to wait before the next one;
  // nullopt if that would fail too.
  std::optional<Nanoseconds> wait_after(const std::optional<protocol::Refused>& refusal) {
    if (!wanted_ || (refusal && refusal->code == protocol::RefusalCode::kept_out)) return std::nullopt;
    const Nanoseconds from = retry_;
    retry_ = std::min(2 * retry_, kLongestRetry);
    return spread(from, 2 * from);
  }

  bool wanted() const { return wanted_; }
  void moved() { wanted_ = false; }

  // The clients of a server that drains are told all at once, and come to the door one by one.
  static constexpr Nanoseconds kLongestSpread = std::chrono::seconds(2);
  static constexpr Nanoseconds kFirstRetry = std::chrono::milliseconds(300);
  static constexpr Nanoseconds kLongestRetry = std::chrono::seconds(4);

 private:
  Nanoseconds spread(Nanoseconds least, Nanoseconds most) {
    return Nanoseconds(std::uniform_int_distribution<int64_t>(least.count(), most.count())(random_));
  }

  bool wanted_ = false;
  Nanoseconds retry_ = kFirstRetry;
  std::minstd_rand random_;
};

}  // namespace gnomon::client
