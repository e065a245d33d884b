// Decides when the next camera is sent: at a steady rate, within a window of unanswered cameras, or when an answer
// takes so long that it must be lost. Time is an argument. One thread.
#pragma once

#include <cstddef>

#include "common/clock.h"

namespace gnomon::client {

struct PaceOptions {
  double rate_hz = 0;        // 0: as soon as the window allows
  size_t max_in_flight = 1;  // 0: no window; then there must be a rate
};

class CameraPacer {
 public:
  // The first camera may be sent at `start`.
  CameraPacer(const PaceOptions& options, TimePoint start)
      : options_(options), next_by_rate_(start), last_sent_(start) {}

  // The next camera's time, in the past if it may be sent at once.
  TimePoint next_send(size_t in_flight) const;

  void sent(TimePoint now);
  void answered(Nanoseconds response);

  // How long after the last camera a full window waits: the mean plus four mean deviations of the response time, as
  // TCP's retransmission timer (RFC 6298), so that a slow server is not taken for a lossy one; at least 1 s.
  Nanoseconds answer_patience() const;
  bool any_answer() const { return any_answer_; }

 private:
  PaceOptions options_;
  TimePoint next_by_rate_;
  TimePoint last_sent_;
  bool any_answer_ = false;
  Nanoseconds mean_response_{};
  Nanoseconds mean_deviation_{};
};

}  // namespace gnomon::client
