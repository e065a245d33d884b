// What a session's link lets go, over its control connection: for clients that no datagrams reach.
#pragma once

#include <optional>

#include "daemon/metrics/faults.h"
#include "daemon/net/control_stream.h"
#include "daemon/session/session.h"

namespace gnomon::daemon {

// Sends what may go now. A client that does not read loses frames: what its connection has no room for is dropped, as
// by any link, and a fault. The net thread's.
std::optional<Fault> send_over_control(Session& session, ControlStream& stream, TimePoint now);

}  // namespace gnomon::daemon
