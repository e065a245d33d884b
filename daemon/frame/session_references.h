// The earlier frames of a session that its client keeps, and that slices of further frames may refer to.
//
//   encode worker: sent(frame)   net thread: client_has(frame)   encode worker: newest() for the next frame
#pragma once

#include <mutex>

#include "protocol/mask_reference.h"

namespace gnomon::daemon {

// Any thread; the lock is held only to copy a few pointers.
class SessionReferences {
 public:
  // A frame of codec tiles_context, as the client will decode it.
  void sent(protocol::MaskReferencePtr frame) {
    std::lock_guard lock(mutex_);
    if (sent_.size() == kFrames) {
      if (sent_.front() == has_) has_.reset();  // the client may drop it soon
      sent_.pop_front();
    }
    sent_.push_back(std::move(frame));
  }

  // `frame`: the newest frame that the client keeps, by its newest camera update; 0 if it keeps none. Slices may refer
  // to that frame only; earlier ones are dropped.
  void client_has(FrameId frame) {
    std::lock_guard lock(mutex_);
    if (has_ && has_->frame() == frame) return;
    has_.reset();
    for (size_t i = 0; i < sent_.size(); ++i) {
      if (sent_[i]->frame() != frame) continue;
      sent_.erase(sent_.begin(), sent_.begin() + static_cast<ptrdiff_t>(i));
      has_ = sent_.front();
      return;
    }
  }

  // The frame that slices may refer to; nullptr if there is none of that shape.
  protocol::MaskReferencePtr newest(const TileGrid& grid) const {
    std::lock_guard lock(mutex_);
    return has_ && has_->grid() == grid ? has_ : nullptr;
  }

 private:
  // Fewer than a client keeps, as some frames are being encoded while the newest one is looked up.
  static constexpr size_t kFrames = protocol::ReferenceShelf::kFrames - 4;

  mutable std::mutex mutex_;
  std::deque<protocol::MaskReferencePtr> sent_;  // oldest first
  protocol::MaskReferencePtr has_;               // nullptr or sent_.front()
};

using SessionReferencesPtr = std::shared_ptr<SessionReferences>;

}  // namespace gnomon::daemon
