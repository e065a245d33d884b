// The frames of a session that its link is sending, in their order.
#pragma once

#include <deque>
#include <optional>

#include "daemon/frame/frame.h"
#include "daemon/link/link_sender.h"

namespace gnomon::daemon {

// Belongs to its session; outlived by the session's link.
class FramesUnderWay {
 public:
  explicit FramesUnderWay(LinkSender& link) : link_(link) {}

  // A frame that was added to the link, as that many bytes.
  void add(const FrameMeta& meta, size_t bytes) { frames_.push_back({meta, bytes}); }

  struct Ended {
    FrameMeta meta;
    size_t bytes = 0;
    bool complete = false;  // every part of it was sent in time
  };

  // A frame whose sending has ended since the last call; nullopt if there is none.
  std::optional<Ended> take_ended() {
    while (const auto end = link_.take_end()) {
      while (!frames_.empty()) {
        const Frame frame = frames_.front();
        frames_.pop_front();
        if (frame.meta.route.frame == end->frame) return Ended{frame.meta, frame.bytes, end->complete};
      }
    }
    return std::nullopt;
  }

 private:
  struct Frame {
    FrameMeta meta;
    size_t bytes = 0;
  };

  LinkSender& link_;
  std::deque<Frame> frames_;
};

}  // namespace gnomon::daemon
