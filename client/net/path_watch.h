// Decides how the contents of a session's datagrams travel: as datagrams or, where those do not pass, over the control
// connection. Time is an argument. One thread.
//
// While nothing arrives the client pings; a server answers each ping at once, however busy it is. Both are as long as
// the longest datagram that every session uses, so that a path which carries only shorter ones counts as closed.
#pragma once

#include <algorithm>
#include <string_view>

#include "common/clock.h"
#include "common/result.h"

namespace gnomon::client {

enum class Transport { automatic, udp, tcp };

// "auto", "udp" or "tcp".
Result<Transport> parse_transport(std::string_view text);

class PathWatch {
 public:
  // The interval at which ping_due() is to be called.
  static constexpr Nanoseconds kInterval = std::chrono::milliseconds(250);

  explicit PathWatch(Transport wanted) : wanted_(wanted), by_udp_(wanted != Transport::tcp) {}

  bool by_udp() const { return by_udp_; }

  // To be called when a datagram has arrived.
  void heard(TimePoint now) {
    heard_ = now;
    quiet_since_ = kNever;
    if (wanted_ == Transport::automatic) by_udp_ = true;
  }

  // True if a ping is to be sent now, as a datagram. May change by_udp().
  bool ping_due(TimePoint now) {
    if (wanted_ != Transport::automatic) return false;
    if (!by_udp_) return try_again(now);
    const bool ever_heard = heard_ != kNever;
    if (ever_heard && now - heard_ < kQuiet) return false;
    if (quiet_since_ == kNever) quiet_since_ = now;
    if (now - quiet_since_ >= (ever_heard ? kPatience : kFirstPatience)) give_up(now);
    return true;
  }

 private:
  static constexpr TimePoint kNever = TimePoint::max();
  static constexpr Nanoseconds kQuiet = std::chrono::milliseconds(500);
  static constexpr Nanoseconds kPatience = std::chrono::seconds(2);  // eight pings in a row are not lost by chance
  static constexpr Nanoseconds kFirstPatience = std::chrono::seconds(1);
  static constexpr Nanoseconds kFirstRetry = std::chrono::seconds(5);
  static constexpr Nanoseconds kLastRetry = std::chrono::minutes(2);

  void give_up(TimePoint now) {
    by_udp_ = false;
    next_try_ = now + retry_;
    retry_ = std::min(2 * retry_, kLastRetry);  // an unstable path is tried less and less often
  }

  bool try_again(TimePoint now) {
    if (now < next_try_) return false;
    next_try_ = now + retry_;
    return true;
  }

  Transport wanted_;
  bool by_udp_;
  TimePoint heard_ = kNever;
  TimePoint quiet_since_ = kNever;
  TimePoint next_try_{};
  Nanoseconds retry_ = kFirstRetry;
};

}  // namespace gnomon::client
