// The frames that a stream has requested and what became of each: their ids are consecutive, from 1 to the newest.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "common/clock.h"
#include "common/ids.h"
#include "protocol/messages.h"

namespace gnomon::client {

class RequestedFrames {
 public:
  struct Request {
    protocol::CameraView camera;
    TimePoint sent;
    uint32_t index = 0;  // the caller's number of the camera
    std::optional<TimePoint> last_slice;
    bool answered = false;
  };
  struct Dropped {
    uint64_t superseded = 0;  // a newer frame has been answered
    uint64_t unanswered = 0;
  };

  FrameId add(const protocol::CameraView& camera, TimePoint now, uint32_t index = 0);
  void answered(FrameId frame);  // one that find() finds

  // nullptr if the frame was never requested or has been dropped. Borrowed until the next add() or drop_old().
  Request* find(FrameId frame);
  bool ever_requested(FrameId frame) const { return frame.value != 0 && frame <= newest_; }

  FrameId newest() const { return newest_; }  // 0 if none was requested
  // Frames newer than the newest answered one.
  size_t in_flight() const { return newest_.value - newest_answered_.value; }

  // Frames of which some slices have come, the last of them `patience` ago or earlier.
  std::vector<FrameId> overdue(TimePoint now, Nanoseconds patience) const;
  // Drops the oldest frames, up to the first that is unanswered and younger than `timeout`.
  Dropped drop_old(TimePoint now, Nanoseconds timeout);

 private:
  FrameId oldest() const { return FrameId{newest_.value + 1 - static_cast<uint32_t>(requests_.size())}; }

  std::deque<Request> requests_;  // of the consecutive ids up to newest_
  FrameId newest_{0};
  FrameId newest_answered_{0};
};

}  // namespace gnomon::client
