// Encoded frames on their way out: slice headers filled in, handed to the session's link; and what the link lets go,
// sealed and handed to the kernel, in batches.
#pragma once

#include <optional>
#include <vector>

#include "daemon/metrics/faults.h"
#include "daemon/net/data_socket.h"
#include "daemon/session/session.h"

namespace gnomon::daemon {

// Keeps its buffers from batch to batch. The net thread's.
class FrameSender {
 public:
  // The frame waits in the session's link then. Returns the bytes that it will take.
  size_t add(EncodedFrame& frame, Session& session, TimePoint now);

  // Sends what may go now. Precondition: the session has an address. A fault: the kernel did not take everything; what
  // it did not take is lost as on any link.
  std::optional<Fault> send(Session& session, DataSocket& socket, TimePoint now);

  // One datagram, at once; lost if the kernel does not take it.
  void answer_ping(Session& session, DataSocket& socket, const asio::ip::udp::endpoint& to);

 private:
  size_t fill(Session& session, TimePoint now);

  static constexpr size_t kBatch = DataSocket::kBatch;

  std::array<std::vector<uint8_t>, kBatch> datagrams_;
};

}  // namespace gnomon::daemon
