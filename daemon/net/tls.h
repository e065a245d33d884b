// What gnomond proves itself with and asks of clients, as the context of all its control connections. TLS 1.3 alone.
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
  protocol::Pin pin{};  // of our certificate
};

// Reads the certificates that the configuration names, or, in demo mode, those that were made at the first start.
// Error: the key, the file and what would help, as for a private key that others may read.
Result<std::shared_ptr<Tls>> open_tls(const ServerConfig& config);

// What new connections are met with. Connections that stand keep what they began with.
using PublishedTls = Published<std::shared_ptr<Tls>>;

}  // namespace gnomon::daemon
