// Hands encoded frames, with their slice headers filled in, to the session's link, and sends what the link releases:
// sealed, in batches, over UDP.
#pragma once

#include <optional>
#include <vector>

#include "daemon/metrics/faults.h"
#include "daemon/net/data_socket.h"
#include "daemon/session/session.h"

namespace gnomon::daemon {

// Reuses its buffers from batch to batch. Belongs to the net thread.
class FrameSender {
 public:
  // Adds the frame to the session's link. Returns the bytes of its datagrams.
  size_t add(EncodedFrame& frame, Session& session, TimePoint now);

  // Sends what the link releases now. Precondition: the session's path has a current address. Returns a fault if the
  // kernel did not take everything: the rest of the batch is lost, as on the network. After a datagram that is too long for
  // the local interface the rest of its batch is lost too, and sending goes on.
  std::optional<Fault> send(Session& session, DataSocket& socket, TimePoint now);

  // Sends the challenges that are due to the address that is to be validated.
  void send_challenges(Session& session, DataSocket& socket, TimePoint now);

  // Sends one datagram at once; it is lost if the kernel does not take it.
  void answer_ping(Session& session, DataSocket& socket, const asio::ip::udp::endpoint& to, TimePoint now);

 private:
  void send_one(Session& session, DataSocket& socket, protocol::DatagramKind kind, std::span<const uint8_t> body,
                const asio::ip::udp::endpoint& to, TimePoint now);
  size_t fill(Session& session, TimePoint now);

  static constexpr size_t kBatch = DataSocket::kBatch;

  std::array<std::vector<uint8_t>, kBatch> datagrams_;
};

}  // namespace gnomon::daemon
