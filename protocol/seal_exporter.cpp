#include "protocol/seal_exporter.h"

#include <openssl/ssl.h>

#include <cstring>
#include <string_view>

namespace gnomon::protocol {
namespace {

// Session and cipher are part of what is hashed: whoever mistakes one gets other keys, not wrong ones of the same.
std::array<uint8_t, 9> exporter_context(SessionId session, CipherId cipher) {
  std::array<uint8_t, 9> bytes;
  std::memcpy(bytes.data(), &session.value, 8);
  bytes[8] = static_cast<uint8_t>(cipher);
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
    return Error{"the TLS session gives no keys"};
  }
  return secrets;
}

}  // namespace gnomon::protocol
