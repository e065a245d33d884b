// The TLS context of all control connections: the server's certificate, and which client certificates are accepted.
// TLS 1.3 only.
#pragma once

#include <asio/ssl/context.hpp>
#include <memory>

#include "common/published.h"
#include "common/result.h"
#include "daemon/config/config.h"
#include "daemon/metrics/status.h"
#include "protocol/pin.h"

namespace gnomon::daemon {

struct Tls {
  asio::ssl::context context{asio::ssl::context::tls_server};
  protocol::Pin pin{};  // of the server's certificate
};

// Reads the certificate and key that the configuration names; in demo mode without them, the demo certificate. The
// error names the configuration key, the file and the remedy, for example if others may read the private key.
Result<std::shared_ptr<Tls>> open_tls(const ServerConfig& config);

// The context of new connections. Established connections keep the one that they began with.
using PublishedTls = Published<std::shared_ptr<Tls>>;

}  // namespace gnomon::daemon
