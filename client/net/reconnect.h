// How long a client that lost its server waits before each attempt to reconnect: exponential backoff. Reads no clock.
#pragma once

#include <algorithm>
#include <optional>

#include "common/clock.h"
#include "protocol/messages.h"

namespace gnomon::client {

class Reconnect {
 public:
  static constexpr Nanoseconds kFirst = std::chrono::milliseconds(250);
  static constexpr Nanoseconds kLongest = std::chrono::seconds(8);

  // How long to wait after a failure, doubled each time up to kLongest; nullopt if another attempt would fail too.
  // `refusal` is the server's, if it refused.
  std::optional<Nanoseconds> wait_after(const std::optional<protocol::Refused>& refusal) {
    if (refusal && !may_pass(refusal->code)) return std::nullopt;
    const Nanoseconds wait = next_;
    next_ = std::min(2 * next_, kLongest);
    return wait;
  }
  void connected() { next_ = kFirst; }

 private:
  static bool may_pass(protocol::RefusalCode code) {
    using enum protocol::RefusalCode;
    return code == scene_unavailable || code == too_many_sessions || code == over_capacity || code == draining ||
           code == internal;
  }

  Nanoseconds next_ = kFirst;
};

}  // namespace gnomon::client
