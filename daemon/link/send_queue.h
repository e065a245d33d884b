// The datagrams that wait to be sent, in their order: what goes again comes first, then frames as they were added. Pure.
#pragma once

#include <cstdint>
#include <deque>
#include <optional>

#include "common/ids.h"
#include "daemon/link/loss_detection.h"

namespace gnomon::daemon {

struct QueuedDatagram {
  uint64_t answer = 0;  // StoredFrame::answer()
  FrameId frame{};
  Cargo cargo = Cargo::slice;
  uint16_t number = 0;  // of the slice, or of the parity datagram
  size_t bytes = 0;     // of the UDP payload
  bool again = false;   // a retransmission
};

// The first sending of a frame has ended.
struct FrameEnd {
  FrameId frame;
  bool complete = false;  // false if some of it was dropped: its deadline passed, or newer frames took its place
};

class SendQueue {
 public:
  void push(const QueuedDatagram& datagram);

  // Borrowed until the next call; nullptr if nothing waits.
  const QueuedDatagram* front() const;

  // Removes the first datagram of the retransmissions or of the first sendings. `sent`: false if it was dropped.
  void pop(bool again, bool sent);

  size_t bytes() const { return bytes_; }
  std::optional<FrameEnd> take_end();

 private:
  std::deque<QueuedDatagram> again_, first_;
  size_t bytes_ = 0;      // of both
  bool complete_ = true;  // the frame of first_.front(), as far as it has been sent
  std::deque<FrameEnd> ends_;
};

}  // namespace gnomon::daemon
