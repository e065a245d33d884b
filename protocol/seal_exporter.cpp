#include "protocol/seal_exporter.h"

#include <openssl/hmac.h>
#include <openssl/ssl.h>

#include <cstring>
#include <string_view>

namespace gnomon::protocol {
namespace {

constexpr const char* kNoKeys = "the TLS session gives no keys";

// Session and cipher are part of the exporter's context, so that a side which mistakes either derives unrelated keys.
std::array<uint8_t, 9> exporter_context(SessionId session, CipherId cipher) {
  std::array<uint8_t, 9> bytes;
  std::memcpy(bytes.data(), &session.value, 8);
  bytes[8] = static_cast<uint8_t>(cipher);
  return bytes;
}

std::array<uint8_t, 8> exporter_context(SessionId session) {
  std::array<uint8_t, 8> bytes;
  std::memcpy(bytes.data(), &session.value, 8);
  return bytes;
}

bool export_one(ssl_st* tls, std::string_view label, std::span<const uint8_t> context, Secret& out) {
  return SSL_export_keying_material(tls, out.data(), out.size(), label.data(), label.size(), context.data(),
                                    context.size(), 1) == 1;
}

}  // namespace

Result<SealSecrets> export_secrets(ssl_st* tls, SessionId session, CipherId cipher) {
  const auto context = exporter_context(session, cipher);
  SealSecrets secrets;
  if (SSL_version(tls) != TLS1_3_VERSION ||
      !export_one(tls, "EXPERIMENTAL gnomon 2 client", context, secrets.client) ||
      !export_one(tls, "EXPERIMENTAL gnomon 2 server", context, secrets.server)) {
    return Error{kNoKeys};
  }
  return secrets;
}

Result<Secret> export_resumption_secret(ssl_st* tls, SessionId session) {
  Secret secret;
  if (SSL_version(tls) != TLS1_3_VERSION ||
      !export_one(tls, "EXPERIMENTAL gnomon 2 resumption", exporter_context(session), secret)) {
    return Error{kNoKeys};
  }
  return secret;
}

Result<Secret> resumption_proof(ssl_st* tls, SessionId session, const Secret& resumption_secret) {
  Secret challenge, proof;
  if (SSL_version(tls) != TLS1_3_VERSION ||
      !export_one(tls, "EXPERIMENTAL gnomon 2 challenge", exporter_context(session), challenge)) {
    return Error{kNoKeys};
  }
  unsigned size = 0;
  if (!HMAC(EVP_sha256(), resumption_secret.data(), static_cast<int>(resumption_secret.size()), challenge.data(),
            challenge.size(), proof.data(), &size)) {
    return Error{kNoKeys};
  }
  return proof;
}

}  // namespace gnomon::protocol
