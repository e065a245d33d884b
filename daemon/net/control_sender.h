// Sends a session's frames over its control connection, for clients that UDP datagrams do not reach.
#pragma once

#include <optional>

#include "daemon/metrics/faults.h"
#include "daemon/net/control_stream.h"
#include "daemon/session/session.h"

namespace gnomon::daemon {

// Sends what the session's link releases now. What the connection has no room for is dropped, as on a lossy link, and
// Fault::socket_full is returned; nullopt otherwise. The net thread.
std::optional<Fault> send_over_control(Session& session, ControlStream& stream, TimePoint now);

}  // namespace gnomon::daemon
