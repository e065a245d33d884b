#include "daemon/frame_sender.h"

#include <algorithm>

namespace gnomon::daemon {

void FrameSender::seal(EncodedFrame& frame, Session& session, TimePoint now) {
  count_ = frame.slices.slices.size();
  if (datagrams_.size() < count_) datagrams_.resize(count_);
  for (size_t i = 0; i < count_; ++i) {
    protocol::SliceHeader& header = frame.slices.slices[i];
    header.frame = frame.meta.frame;
    header.server_us = static_cast<uint32_t>(to_microseconds(now - frame.meta.arrival));
    if (frame.meta.moment) {
      header.flags |= protocol::kSliceHasMoment;
      header.moment = *frame.meta.moment;
    }
    header.gpu_us = static_cast<uint32_t>(to_microseconds(frame.meta.gpu));
    body_.clear();
    protocol::append_frame_slice(body_, header, frame.slices.payload(i));
    session.seal().seal(protocol::DatagramKind::frame_slice, body_, datagrams_[i]);
  }
}

Sent FrameSender::send(EncodedFrame& frame, Session& session, DataSocket& socket) {
  seal(frame, session, Clock::now());
  const auto datagrams = std::span<const std::vector<uint8_t>>(datagrams_).first(count_);
  asio::error_code error;
  const size_t taken = socket.send(datagrams, *session.address(), error);
  Sent sent;
  for (const auto& datagram : datagrams.first(taken)) sent.bytes += datagram.size();
  if (taken < count_) sent.fault = error ? Fault::send_failed : Fault::socket_full;
  return sent;
}

}  // namespace gnomon::daemon
