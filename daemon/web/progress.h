// How long a stranger is served over HTTP: for as long as bytes move. A request has to be complete, and an answer taken,
// in steps: kStepBytes move within the patience, or the connection is cut, so that a slow link that takes
// bytes steadily goes on for as long as its answer is long, and one that dawdles does not hold its place. Pure; the
// caller passes the time.
#pragma once

#include <cstddef>

#include "common/clock.h"

namespace gnomon::daemon::web {

class Progress {
 public:
  // A reader takes so many bytes within `patience`, or what is left of its answer.
  static constexpr size_t kStepBytes = 32 * 1024;

  Progress(Nanoseconds patience, TimePoint now) : patience_(patience), deadline_(now + patience) {}

  // The next request is waited for, from now on. Its bytes gain no time: a request is short.
  void asks(TimePoint now) { begin(State::asking, now); }
  // The answer is being made, for as long as it takes: the delay is ours.
  void waits() {
    state_ = State::waiting;
    deadline_ = TimePoint::max();
  }
  // The answer is being sent.
  void answers(TimePoint now) { begin(State::answering, now); }
  void sent(size_t bytes, TimePoint now) {
    if (state_ != State::answering) return;
    moved_ += bytes;
    if (moved_ >= kStepBytes) begin(State::answering, now);
  }

  TimePoint deadline() const { return deadline_; }  // then the connection is closed

 private:
  enum class State { asking, waiting, answering };

  void begin(State state, TimePoint now) {
    state_ = state;
    moved_ = 0;
    deadline_ = now + patience_;
  }

  Nanoseconds patience_;
  State state_ = State::asking;
  size_t moved_ = 0;  // bytes since the step began
  TimePoint deadline_;
};

}  // namespace gnomon::daemon::web
