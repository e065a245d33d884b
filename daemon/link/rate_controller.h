// How many bytes a second a session may send. Pure.
//
// Delay-based, in the spirit of LEDBAT (RFC 6817), SCReAM (RFC 8298) and Google's congestion control
// (draft-ietf-rmcat-gcc-02): the rate grows while datagrams do not queue, falls to a part of what the path delivers
// when they do, and does not grow again until the queue has drained. Unlike LEDBAT the controller does not yield for
// ever: if the queue does not react to the lower rate, another flow is filling it, and the controller competes as TCP
// does for a while (the mode switch of Copa: Arun and Balakrishnan, NSDI 2018; TCP's part: RFC 5681 with CUBIC's
// factor). Losses without a queue are taken for a property of the path: the rate falls only if they are many, and only
// while that helps.
#pragma once

#include <cstddef>
#include <cstdint>

#include "common/clock.h"

namespace gnomon::daemon {

// The summary of one Feedback.
struct PathReport {
  Nanoseconds rtt{};                         // smoothed; includes queueing
  Nanoseconds queue{};                       // queueing on the way to the client
  double delivered = 0;                      // bytes a second that arrived lately
  uint32_t arrived = 0;                      // datagrams
  uint32_t lost = 0;                         // datagrams
  bool limited = false;                      // the rate held datagrams or views back
  TimePoint newest_sent = TimePoint::max();  // when the newest datagram that arrived was sent
};

class RateController {
 public:
  static constexpr double kFirstRate = 250e3;  // bytes a second, as the next two
  static constexpr double kLeastRate = 30e3;
  static constexpr double kMostRate = 1.25e9;
  static constexpr Nanoseconds kTarget = std::chrono::milliseconds(8);  // of queueing

  double rate() const { return rate_; }  // bytes a second
  double loss() const { return loss_; }  // share of datagrams, smoothed over about 100 of them
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
  TimePoint hold_until_{};  // until then reports do not reflect the last change
  bool starting_ = true;
  bool draining_ = false;  // the rate is below what the path delivers until the queue is gone
  TimePoint fell_{};       // of the last fall; datagrams sent before it do not reflect it, however long they queued
  double delivered_ = 0;   // bytes a second, when the queue began
  double clear_rtts_ = 0;  // round trips without a queue

  uint32_t in_vain_ = 0;      // falls in a row that did not shorten the queue
  Nanoseconds queue_then_{};  // at the last fall
  double rate_then_ = 0;      // before the first fall in a row
  TimePoint competing_until_{};

  double loss_ = 0;
  uint32_t shed_ = 0;  // falls in a row for the sake of losses
  double loss_then_ = 0;
  TimePoint ignore_losses_until_{};
};

}  // namespace gnomon::daemon
