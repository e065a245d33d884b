// What a session's client has of earlier frames, as far as slices may refer to it.
//
//   encode worker: sent(frame)   net thread: client_has(frame)   encode worker: newest() for the next frame
#pragma once

#include <mutex>

#include "protocol/mask_reference.h"

namespace gnomon::daemon {

// Any thread; its lock is held for a few pointers.
class SessionReferences {
 public:
  // A frame of tiles_context, as the client will have it.
  void sent(protocol::MaskReferencePtr frame) {
    std::lock_guard lock(mutex_);
    if (sent_.size() == kFrames) {
      if (sent_.front() == has_) has_.reset();  // the client may give it up soon
      sent_.pop_front();
    }
    sent_.push_back(std::move(frame));
  }

  // What the client's newest camera update says: the newest frame that it keeps; 0: none. Only to that one may slices
  // refer; those before will not be needed any more.
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

  // Null: none of that shape.
  protocol::MaskReferencePtr newest(const TileGrid& grid) const {
    std::lock_guard lock(mutex_);
    return has_ && has_->grid() == grid ? has_ : nullptr;
  }

 private:
  // Fewer than a client keeps: some frames are being encoded while the newest one is looked up.
  static constexpr size_t kFrames = protocol::ReferenceShelf::kFrames - 4;

  mutable std::mutex mutex_;
  std::deque<protocol::MaskReferencePtr> sent_;  // the oldest first
  protocol::MaskReferencePtr has_;               // if not null, the first of them
};

using SessionReferencesPtr = std::shared_ptr<SessionReferences>;

}  // namespace gnomon::daemon
