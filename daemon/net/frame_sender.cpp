#include "daemon/net/frame_sender.h"

#include <algorithm>

namespace gnomon::daemon {

size_t FrameSender::add(EncodedFrame& frame, Session& session, TimePoint now) {
  for (protocol::SliceHeader& header : frame.slices.slices) {
    header.frame = frame.meta.route.frame;
    header.server_us = static_cast<uint32_t>(to_microseconds(now - frame.meta.times.arrival));
    if (frame.meta.spec.moment) {
      header.flags |= protocol::kSliceHasMoment;
      header.moment = *frame.meta.spec.moment;
    }
    if (frame.meta.spec.tells_size) {
      header.flags |= protocol::kSliceHasSize;
      header.width = static_cast<uint16_t>(frame.meta.spec.grid.width);
      header.height = static_cast<uint16_t>(frame.meta.spec.grid.height);
    }
    if (frame.meta.spec.tells_samples) {
      header.flags |= protocol::kSliceHasSamples;
      header.samples = to_byte(frame.meta.spec.samples);
    }
    header.gpu_us = static_cast<uint32_t>(to_microseconds(frame.meta.times.gpu));
  }
  return session.link().add(frame.slices, frame.meta.times.deadline, now);
}

// Seals what the link releases into datagrams_; returns how many. A probe ends the batch: datagrams after it would not
// be sent if the local interface refuses its length.
size_t FrameSender::fill(Session& session, TimePoint now) {
  LinkSender& link = session.link();
  for (size_t count = 0; count < kBatch;) {
    const auto out = link.next(now);
    if (!out) return count;
    std::vector<uint8_t>& datagram = datagrams_[count++];
    session.omit_number();
    const uint64_t sequence = session.seal().seal(out->kind, out->body, datagram);
    link.sent(sequence, datagram.size(), now);
    if (out->kind == protocol::DatagramKind::probe) return count;
  }
  return kBatch;
}

void FrameSender::answer_ping(Session& session, DataSocket& socket, const asio::ip::udp::endpoint& to,
                              TimePoint now) {
  static constexpr std::array<uint8_t, protocol::kPingBytes> kZeros{};
  send_one(session, socket, protocol::DatagramKind::pong, kZeros, to, now);
  session.path().sent(to, datagrams_[0].size());
}

void FrameSender::send_challenges(Session& session, DataSocket& socket, TimePoint now) {
  while (const auto challenge = session.path().challenge_due(now)) {
    std::vector<uint8_t> body;
    protocol::append_path_token(body, challenge->token);
    send_one(session, socket, protocol::DatagramKind::path_challenge, body, challenge->to, now);
  }
}

void FrameSender::send_one(Session& session, DataSocket& socket, protocol::DatagramKind kind,
                           std::span<const uint8_t> body, const asio::ip::udp::endpoint& to, TimePoint now) {
  const uint64_t sequence = session.seal().seal(kind, body, datagrams_[0]);
  session.link().sent(sequence, datagrams_[0].size(), now);
  asio::error_code ignored;
  socket.send(std::span(datagrams_).first(1), to, ignored);
}

std::optional<Fault> FrameSender::send(Session& session, DataSocket& socket, TimePoint now) {
  while (const size_t count = fill(session, now)) {
    asio::error_code error;
    const size_t taken = socket.send(std::span(datagrams_).first(count), *session.path().current(), error);
    if (taken == count || error == asio::error::message_size) continue;
    return error ? Fault::send_failed : Fault::socket_full;
  }
  return std::nullopt;
}

}  // namespace gnomon::daemon
