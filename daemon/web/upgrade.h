// The handshake by which an HTTP connection goes on as a WebSocket that carries control messages (RFC 6455, 4.2). Pure.
#pragma once

#include "daemon/web/web_response.h"

namespace gnomon::daemon::web {

inline constexpr const char* kSubprotocol = "gnomon";

// 101 if the connection goes on as a WebSocket once this response is sent; else why it does not. A browser says which
// page asks (Origin): only ours may, as any other could speak in the name of who looks at it.
Response upgrade(const Request& request);

}  // namespace gnomon::daemon::web
