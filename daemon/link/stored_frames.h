// The last few frames that were handed over for sending, oldest first. Pure.
#pragma once

#include <deque>

#include "daemon/link/stored_frame.h"

namespace gnomon::daemon {

class StoredFrames {
 public:
  // Drops the oldest frame if there are kMostFrames already. Borrowed until the next call that drops frames.
  StoredFrame& add(const protocol::EncodedMask& slices, TimePoint deadline, bool pad) {
    if (frames_.size() == kMostFrames) frames_.pop_front();
    return frames_.emplace_back(slices, ++answers_, deadline, pad);
  }

  // nullptr if the frame was dropped.
  StoredFrame* find(uint64_t answer) {
    for (StoredFrame& stored : frames_) {
      if (stored.answer() == answer) return &stored;
    }
    return nullptr;
  }

  // nullptr if none is kept.
  const StoredFrame* newest() const { return frames_.empty() ? nullptr : &frames_.back(); }
  void drop_newest() { frames_.pop_back(); }

  void drop_expired(TimePoint now) {
    while (!frames_.empty() && frames_.front().useful_until() <= now) frames_.pop_front();
  }

 private:
  static constexpr size_t kMostFrames = 4;

  std::deque<StoredFrame> frames_;
  uint64_t answers_ = 0;
};

}  // namespace gnomon::daemon
