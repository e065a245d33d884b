#include "daemon/link/send_queue.h"

namespace gnomon::daemon {

void SendQueue::push(const QueuedDatagram& datagram) {
  (datagram.again ? again_ : first_).push_back(datagram);
  bytes_ += datagram.bytes;
}

const QueuedDatagram* SendQueue::front() const {
  if (!again_.empty()) return &again_.front();
  return first_.empty() ? nullptr : &first_.front();
}

void SendQueue::pop(bool again, bool sent) {
  std::deque<QueuedDatagram>& queue = again ? again_ : first_;
  const QueuedDatagram popped = queue.front();
  queue.pop_front();
  bytes_ -= popped.bytes;
  if (again) return;
  complete_ = complete_ && sent;
  if (!first_.empty() && first_.front().answer == popped.answer) return;
  ends_.push_back({popped.frame, complete_});
  complete_ = true;
}

std::optional<FrameEnd> SendQueue::take_end() {
  if (ends_.empty()) return std::nullopt;
  const FrameEnd end = ends_.front();
  ends_.pop_front();
  return end;
}

}  // namespace gnomon::daemon
