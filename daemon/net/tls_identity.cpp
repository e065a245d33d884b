#include "daemon/net/tls_identity.h"

#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>

#include <functional>
#include <memory>
#include <string>

#include "daemon/security/freed_by.h"

namespace gnomon::daemon {
namespace {

template <class T, auto Free>
using Owned = std::unique_ptr<T, FreedBy<Free>>;

std::string pem(const std::function<int(BIO*)>& write) {
  const Owned<BIO, BIO_free> out(BIO_new(BIO_s_mem()));
  if (!out || write(out.get()) != 1) return {};
  char* text = nullptr;
  const long size = BIO_get_mem_data(out.get(), &text);
  return {text, static_cast<size_t>(size)};
}

bool is_trusted(X509* certificate, STACK_OF(X509) * chain) {
  const Owned<X509_STORE, X509_STORE_free> store(X509_STORE_new());
  const Owned<X509_STORE_CTX, X509_STORE_CTX_free> context(X509_STORE_CTX_new());
  const bool trusted = store && context && X509_STORE_set_default_paths(store.get()) == 1 &&
                       X509_STORE_CTX_init(context.get(), store.get(), certificate, chain) == 1 &&
                       X509_verify_cert(context.get()) == 1;
  ERR_clear_error();
  return trusted;
}

}  // namespace

std::optional<Identity> trusted_identity(asio::ssl::context& context) {
  SSL_CTX* const tls = context.native_handle();
  X509* const certificate = SSL_CTX_get0_certificate(tls);
  STACK_OF(X509)* chain = nullptr;
  SSL_CTX_get0_chain_certs(tls, &chain);
  if (!certificate || !is_trusted(certificate, chain)) return std::nullopt;
  Identity identity;
  identity.certificate = pem([&](BIO* out) { return PEM_write_bio_X509(out, certificate); });
  for (int i = 0; i < sk_X509_num(chain); ++i) {
    identity.certificate += pem([&](BIO* out) { return PEM_write_bio_X509(out, sk_X509_value(chain, i)); });
  }
  identity.key = pem([&](BIO* out) {
    return PEM_write_bio_PrivateKey(out, SSL_CTX_get0_privatekey(tls), nullptr, nullptr, 0, nullptr, nullptr);
  });
  return identity;
}

}  // namespace gnomon::daemon
