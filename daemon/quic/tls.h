// GnuTLS as QUIC's handshake needs it: TLS 1.3 with the application protocol h3.
#pragma once

#include <gnutls/gnutls.h>

#include <memory>

#include "common/result.h"
#include "daemon/security/certificates.h"

namespace gnomon::daemon::quic {

// The certificate and what is negotiated beside it. Constant; each connection holds the one that it began with.
class Credentials {
 public:
  static Result<std::shared_ptr<const Credentials>> make(const Identity& identity);
  ~Credentials();
  Credentials(const Credentials&) = delete;
  Credentials& operator=(const Credentials&) = delete;

  // A session of a server that shows the certificate; nullptr if there is no memory. The caller deinitialises it, and
  // keeps the credentials as long.
  gnutls_session_t new_session() const;

 private:
  Credentials() = default;
  gnutls_certificate_credentials_t certificate_ = nullptr;
  gnutls_priority_t priority_ = nullptr;
};

}  // namespace gnomon::daemon::quic
