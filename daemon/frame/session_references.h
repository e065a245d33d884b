// The earlier frames of a session that its client keeps, and that slices of further frames may refer to.
//
//   encode worker: sent(frame)   net thread: client_has(frame)   encode worker: newest() for the next frame
#pragma once

#include <mutex>

#include "common/sample_counts.h"
#include "protocol/mask_reference.h"

namespace gnomon::daemon {

// Any thread; the lock is held only to copy a few pointers.
class SessionReferences {
 public:
  // A frame of codec tiles_context, as the client will decode it, and the samples in force for it.
  void sent(protocol::MaskReferencePtr frame, SampleCounts samples) {
    std::lock_guard lock(mutex_);
    if (sent_.size() == kFrames) {
      if (sent_.front().frame == has_.frame) has_ = {};  // the client may drop it soon
      sent_.pop_front();
    }
    sent_.push_back({std::move(frame), samples});
  }

  // `frame`: the newest frame that the client keeps, by its newest camera update; 0 if it keeps none. Slices may refer
  // to that frame only; earlier ones are dropped.
  void client_has(FrameId frame) {
    std::lock_guard lock(mutex_);
    if (has_.frame && has_.frame->frame() == frame) return;
    has_ = {};
    for (size_t i = 0; i < sent_.size(); ++i) {
      if (sent_[i].frame->frame() != frame) continue;
      sent_.erase(sent_.begin(), sent_.begin() + static_cast<ptrdiff_t>(i));
      has_ = sent_.front();
      return;
    }
  }

  // The frame that slices may refer to; nullptr if there is none of that shape. A client drops what it keeps when its size
  // or its samples change.
  protocol::MaskReferencePtr newest(const TileGrid& grid, SampleCounts samples) const {
    std::lock_guard lock(mutex_);
    return has_.frame && has_.frame->grid() == grid && has_.samples == samples ? has_.frame : nullptr;
  }

 private:
  // Fewer than a client keeps, as some frames are being encoded while the newest one is looked up.
  static constexpr size_t kFrames = protocol::ReferenceShelf::kFrames - 4;

  struct Sent {
    protocol::MaskReferencePtr frame = nullptr;
    SampleCounts samples = {};
  };

  mutable std::mutex mutex_;
  std::deque<Sent> sent_;  // oldest first
  Sent has_;               // without a frame, or sent_.front()
};

using SessionReferencesPtr = std::shared_ptr<SessionReferences>;

}  // namespace gnomon::daemon
