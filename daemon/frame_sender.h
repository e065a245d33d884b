// An encoded frame on its way out: slice headers filled in, sealed, handed to the kernel.
#pragma once

#include <optional>
#include <vector>

#include "daemon/data_socket.h"
#include "daemon/faults.h"
#include "daemon/session.h"

namespace gnomon::daemon {

struct Sent {
  size_t bytes = 0;
  std::optional<Fault> fault;  // then the rest of the frame was dropped: the client covers what is missing
};

// Keeps its buffers from frame to frame. The net thread's.
class FrameSender {
 public:
  // Precondition: the session has an address.
  Sent send(EncodedFrame& frame, Session& session, DataSocket& socket);

 private:
  void seal(EncodedFrame& frame, Session& session, TimePoint now);

  std::vector<uint8_t> body_;
  std::vector<std::vector<uint8_t>> datagrams_;
  size_t count_ = 0;  // of datagrams_ in use
};

}  // namespace gnomon::daemon
