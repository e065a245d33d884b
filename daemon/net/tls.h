// The TLS context of all control connections: the server's certificate, and which client certificates are accepted.
// TLS 1.3 only.
#pragma once

#include <asio/ssl/context.hpp>
#include <chrono>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "common/published.h"
#include "common/result.h"
#include "daemon/config/config.h"
#include "daemon/security/client_certificates.h"
#include "protocol/pin.h"

namespace gnomon::daemon {

struct Tls {
  asio::ssl::context context{asio::ssl::context::tls_server};
  protocol::Pin pin{};                 // of the server's certificate
  std::chrono::sys_seconds expires{};  // the server's certificate
  std::vector<std::string> names;      // hosts and addresses that the server's certificate is for
  bool browsers = false;               // may choose HTTP in the handshake (ALPN)
  ClientAuthorities authorities;       // of clients' certificates; none if clients are not asked for one
};

// Reads the certificate and key that the configuration names; in demo mode without them, the demo certificate. The
// error names the configuration key, the file and the remedy, for example if others may read the private key. A
// certificate that is out of date is used, as a daemon that runs can be given another one; its clients refuse it.
Result<std::shared_ptr<Tls>> open_tls(const ServerConfig& config, bool browsers = false);

// For a reload: as open_tls(), but the certificate and what is accepted of clients each stay as they are in `before` if
// they cannot be read or, for the certificate, if it is out of date; `kept` says which and why.
struct ReopenedTls {
  std::shared_ptr<Tls> tls;
  std::vector<Error> kept;
};
ReopenedTls reopen_tls(const ServerConfig& config, const Tls& before);

// Why clients refuse the server's certificate, which stands in `file`, at that time: it has expired, or is not valid yet.
// Empty: they do not.
std::string out_of_date(const std::filesystem::path& file, const Tls& tls, std::chrono::sys_seconds now);

// Which of the certificates of a daemon expires first.
struct FirstExpiry {
  const char* key;  // of the configuration
  std::chrono::sys_seconds at;
};
FirstExpiry first_expiry(const Tls& tls);

// The context of new connections. Established connections keep the one that they began with.
using PublishedTls = Published<std::shared_ptr<Tls>>;

}  // namespace gnomon::daemon
