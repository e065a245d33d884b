#include "daemon/quic/tls.h"

#include <ngtcp2/ngtcp2.h>
#include <ngtcp2/ngtcp2_crypto.h>
#include <ngtcp2/ngtcp2_crypto_gnutls.h>

namespace gnomon::daemon::quic {
namespace {

// RFC 9001, 8.4: QUIC has no use for the compatibility mode of TLS 1.3.
constexpr const char* kPriority = "NORMAL:-VERS-ALL:+VERS-TLS1.3:%DISABLE_TLS13_COMPAT_MODE";

gnutls_datum_t datum_of(const std::string& text) {
  return {reinterpret_cast<unsigned char*>(const_cast<char*>(text.data())), static_cast<unsigned>(text.size())};
}

}  // namespace

Result<std::shared_ptr<const Credentials>> Credentials::make(const Identity& identity) {
  std::shared_ptr<Credentials> made(new Credentials);
  const gnutls_datum_t certificate = datum_of(identity.certificate), key = datum_of(identity.key);
  int failed = gnutls_certificate_allocate_credentials(&made->certificate_);
  if (failed >= 0) failed = gnutls_priority_init(&made->priority_, kPriority, nullptr);
  if (failed >= 0) {
    failed = gnutls_certificate_set_x509_key_mem(made->certificate_, &certificate, &key, GNUTLS_X509_FMT_PEM);
  }
  if (failed < 0) return Error{std::string("the certificate cannot be used for QUIC: ") + gnutls_strerror(failed)};
  return std::shared_ptr<const Credentials>(std::move(made));
}

Credentials::~Credentials() {
  if (certificate_) gnutls_certificate_free_credentials(certificate_);
  if (priority_) gnutls_priority_deinit(priority_);
}

gnutls_session_t Credentials::new_session() const {
  gnutls_session_t session = nullptr;
  // Without tickets: connections are short, and a resumed one would prove nothing that ours has to.
  if (gnutls_init(&session, GNUTLS_SERVER | GNUTLS_NO_AUTO_SEND_TICKET | GNUTLS_NO_TICKETS) < 0) return nullptr;
  static const unsigned char kProtocol[] = {'h', '3'};
  gnutls_datum_t protocol{const_cast<unsigned char*>(kProtocol), sizeof kProtocol};
  const bool ready = gnutls_priority_set(session, priority_) >= 0 &&
                     ngtcp2_crypto_gnutls_configure_server_session(session) == 0 &&
                     gnutls_credentials_set(session, GNUTLS_CRD_CERTIFICATE, certificate_) >= 0 &&
                     gnutls_alpn_set_protocols(session, &protocol, 1, GNUTLS_ALPN_MANDATORY) >= 0;
  if (ready) return session;
  gnutls_deinit(session);
  return nullptr;
}

}  // namespace gnomon::daemon::quic
