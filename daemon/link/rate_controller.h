// How many bytes a second a session may send. Pure.
//
// Delay-based, in the spirit of LEDBAT (RFC 6817), SCReAM (RFC 8298) and Google's congestion control
// (draft-ietf-rmcat-gcc-02): grows while datagrams do not queue, falls to a part of what the path delivers when they
// do, and pauses long enough for the queue to drain. Unlike LEDBAT it does not give way for ever: a queue that does
// not react to its falling is filled by somebody else, and then it competes as TCP does (Copa's mode switch: Arun and
// Balakrishnan 2018; TCP's part: RFC 5681 with CUBIC's factor). Losses without a queue are the path's own; only many
// of them slow it down, and only while that helps.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/clock.h"

namespace gnomon::daemon {

// What one Feedback told, summed up.
struct PathReport {
  Nanoseconds rtt{};                         // smoothed; queueing included
  Nanoseconds queue{};                       // of it, on the way to the client
  double delivered = 0;                      // bytes a second that arrived lately
  uint32_t arrived = 0;                      // datagrams
  uint32_t lost = 0;                         // datagrams
  bool limited = false;                      // more would have been sent, had the rate allowed it
  TimePoint newest_sent = TimePoint::max();  // when the newest that arrived left
};

class RateController {
 public:
  static constexpr double kFirstRate = 250e3;  // bytes a second
  static constexpr double kLeastRate = 30e3;
  static constexpr double kMostRate = 1.25e9;
  static constexpr Nanoseconds kTarget = std::chrono::milliseconds(8);  // of queueing

  double rate() const { return rate_; }
  double loss() const { return loss_; }  // share of datagrams, smoothed over about a second's worth
  bool competing(TimePoint now) const { return now < competing_until_; }

  void observe(const PathReport& report, TimePoint now);

 private:
  void count_losses(const PathReport& report);
  void compete(const PathReport& report, TimePoint now, Nanoseconds step);
  void grow(const PathReport& report, Nanoseconds step);
  void fall(const PathReport& report, TimePoint now);
  bool shed_load(TimePoint now, Nanoseconds rtt);
  void set(double rate);

  double rate_ = kFirstRate;
  TimePoint last_{};
  TimePoint hold_until_{};  // the last change has not shown in reports yet
  bool starting_ = true;
  bool draining_ = false;  // below what the path delivers until the queue is gone
  TimePoint fell_{};       // what was sent before says nothing of it, however long it has queued
  double delivered_ = 0;   // when the queue began
  double clear_rtts_ = 0;  // round trips without a queue

  // Falls in a row that did not shorten the queue.
  uint32_t in_vain_ = 0;
  Nanoseconds queue_then_{};
  double rate_then_ = 0;
  TimePoint competing_until_{};

  double loss_ = 0;
  uint32_t shed_ = 0;  // falls in a row for the sake of losses
  double loss_then_ = 0;
  TimePoint ignore_losses_until_{};
};

}  // namespace gnomon::daemon
