// Decides whether a session's next view is requested from the renderer now, or held back because its frame would only
// wait for the link. Pure.
//
// On a slow link the frame rate falls first: the newest camera is held back until the link will be free when its frame
// is ready, so that frames are fewer, not older.
#pragma once

#include <deque>

#include "common/clock.h"
#include "common/ids.h"

namespace gnomon::daemon {

class RequestGate {
 public:
  // True if the next view may be requested. `backlog`: bytes that wait to be sent; `rate`: bytes a second.
  bool open(size_t backlog, double rate, TimePoint now) {
    while (!asked_.empty() && now - asked_.front().at > kForgotten) asked_.pop_front();
    return load(backlog) / rate <= to_seconds(ready_in_ + kSlack);
  }

  // The earliest time at which the link will have caught up, to call open() again.
  TimePoint opens_at(size_t backlog, double rate, TimePoint now) const {
    const double excess = load(backlog) / rate - to_seconds(ready_in_ + kSlack);
    return now + Nanoseconds(static_cast<int64_t>(std::max(kLeastWait, excess) * 1e9));
  }

  void on_request(FrameId frame, TimePoint now) {
    asked_.push_back({frame, now});
    if (asked_.size() > kMostAsked) asked_.pop_front();
  }

  // The frame is ready, as `bytes` to send. Views that were asked for before it will not be answered any more.
  void on_answer(FrameId frame, size_t bytes, TimePoint now) {
    frame_bytes_ += (static_cast<double>(bytes) - frame_bytes_) / (frame_bytes_ == 0 ? 1 : 8);
    while (!asked_.empty() && !is_newer(asked_.front().frame, frame)) {
      if (asked_.front().frame == frame) ready_in_ += (now - asked_.front().at - ready_in_) / 8;
      asked_.pop_front();
    }
  }

 private:
  static constexpr Nanoseconds kSlack = std::chrono::milliseconds(5);
  static constexpr Nanoseconds kForgotten = std::chrono::milliseconds(500);

  static constexpr size_t kMostAsked = 256;   // a client may ask faster than any is answered
  static constexpr double kLeastWait = 1e-3;  // seconds; the wait may be for the renderer, whose time is unknown

  struct Asked {
    FrameId frame;
    TimePoint at;
  };

  double load(size_t backlog) const {
    return static_cast<double>(backlog) + frame_bytes_ * static_cast<double>(asked_.size());
  }

  std::deque<Asked> asked_;
  double frame_bytes_ = 0;  // smoothed
  Nanoseconds ready_in_{};  // from the request to the frame, smoothed
};

}  // namespace gnomon::daemon
