// Sends a session's frames over its control connection, for clients that UDP datagrams do not reach.
#pragma once

#include "daemon/net/control_stream.h"
#include "daemon/session/session.h"

namespace gnomon::daemon {

// Sends what the session's link releases now, as far as the connection has room; the rest waits in the link. Returns
// false if it had no room for everything: the stream calls back when it has. The net thread.
bool send_over_control(Session& session, ControlStream& stream, TimePoint now);

}  // namespace gnomon::daemon
