#include "client/net/trust.h"

#include <openssl/err.h>
#include <openssl/sha.h>
#include <openssl/ssl.h>

#include <array>
#include <asio/ip/address.hpp>
#include <asio/ssl/context.hpp>
#include <fstream>

#include "protocol/messages.h"
#include "protocol/pin.h"

namespace gnomon::client {
namespace {

using protocol::Pin;

Error library_error(const std::string& what) {
  const char* const reason = ERR_reason_error_string(ERR_get_error());
  ERR_clear_error();
  return Error{what + ": " + (reason ? reason : "cannot be read")};
}

Result<Pin> read_pin(const std::string& pin_or_file) {
  if (pin_or_file.starts_with("sha256:")) return protocol::parse_pin(pin_or_file);
  std::ifstream in(pin_or_file);
  std::string line;
  if (!in || !std::getline(in, line)) return Error{"cannot read a fingerprint from " + pin_or_file};
  return protocol::parse_pin(line);
}

// For OpenSSL, which frees it with the context or the connection that it belongs to.
void free_pin(void*, void* pin, CRYPTO_EX_DATA*, int, long, void*) { delete static_cast<Pin*>(pin); }

int index_of_shown_pin() {
  static const int index = SSL_get_ex_new_index(0, nullptr, nullptr, nullptr, free_pin);
  return index;
}

// OpenSSL itself keeps a certificate only once it is accepted.
void remember_shown(X509_STORE_CTX* store) {
  auto* const tls = static_cast<SSL*>(X509_STORE_CTX_get_ex_data(store, SSL_get_ex_data_X509_STORE_CTX_idx()));
  X509* const certificate = X509_STORE_CTX_get0_cert(store);
  if (!tls || !certificate || SSL_get_ex_data(tls, index_of_shown_pin())) return;
  auto* const pin = new Pin(protocol::pin_of(certificate));
  if (SSL_set_ex_data(tls, index_of_shown_pin(), pin) != 1) delete pin;
}

// Called for each certificate of the chain, with OpenSSL's own verdict.
int note_shown(int accepted, X509_STORE_CTX* store) {
  remember_shown(store);
  return accepted;
}

// Replaces OpenSSL's verification: accepts the pinned certificate within its validity period, whoever has signed it.
int verify_pinned(X509_STORE_CTX* store, void* pin) {
  remember_shown(store);
  X509* const certificate = X509_STORE_CTX_get0_cert(store);
  int error = X509_V_OK;
  if (!certificate || protocol::pin_of(certificate) != *static_cast<const Pin*>(pin)) {
    error = X509_V_ERR_CERT_UNTRUSTED;
  } else if (X509_cmp_current_time(X509_get0_notBefore(certificate)) > 0) {
    error = X509_V_ERR_CERT_NOT_YET_VALID;
  } else if (X509_cmp_current_time(X509_get0_notAfter(certificate)) < 0) {
    error = X509_V_ERR_CERT_HAS_EXPIRED;
  }
  X509_STORE_CTX_set_error(store, error);
  return error == X509_V_OK;
}

// The context owns the pin.
void accept_pinned(SSL_CTX* context, const Pin& pin) {
  static const int index = SSL_CTX_get_ex_new_index(0, nullptr, nullptr, nullptr, free_pin);
  auto* const kept = new Pin(pin);
  SSL_CTX_set_ex_data(context, index, kept);
  SSL_CTX_set_cert_verify_callback(context, verify_pinned, kept);
}

Result<void> accept_signed(SSL_CTX* context, const Trust& trust, const std::string& host) {
  const bool loaded = trust.authorities.empty() ? SSL_CTX_set_default_verify_paths(context) == 1
                                                : SSL_CTX_load_verify_file(context, trust.authorities.c_str()) == 1;
  if (!loaded) return library_error(trust.authorities.string());
  asio::error_code not_an_address;
  asio::ip::make_address(host, not_an_address);
  X509_VERIFY_PARAM* const wanted = SSL_CTX_get0_param(context);
  if (not_an_address) {
    X509_VERIFY_PARAM_set1_host(wanted, host.c_str(), host.size());
  } else {
    X509_VERIFY_PARAM_set1_ip_asc(wanted, host.c_str());
  }
  return {};
}

Result<void> show_own(SSL_CTX* context, const Trust& trust) {
  if (trust.certificate.empty() && trust.key.empty()) return {};
  if (SSL_CTX_use_certificate_chain_file(context, trust.certificate.c_str()) != 1) {
    return library_error("client certificate " + trust.certificate.string());
  }
  if (SSL_CTX_use_PrivateKey_file(context, trust.key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return library_error("client key " + trust.key.string());
  }
  return {};
}

}  // namespace

std::string server_name(const Trust& trust, const std::string& host, const std::string& scene) {
  asio::error_code is_name;
  asio::ip::make_address(host, is_name);
  if (trust.fleet.empty()) return is_name ? host : std::string();
  constexpr size_t kBytesSaid = 8;
  std::array<unsigned char, SHA256_DIGEST_LENGTH> hash{};
  SHA256(reinterpret_cast<const unsigned char*>(scene.data()), scene.size(), hash.data());
  std::string name = "s-";
  for (size_t i = 0; i < kBytesSaid; ++i) {
    for (const int digit : {hash[i] >> 4, hash[i] & 15}) name += "0123456789abcdef"[digit];
  }
  return name + "." + trust.fleet;
}

std::string shown_pin(const SSL* tls) {
  const auto* const pin = static_cast<const Pin*>(SSL_get_ex_data(tls, index_of_shown_pin()));
  return pin ? protocol::to_string(*pin) : std::string();
}

Result<std::unique_ptr<asio::ssl::context>> open_trust(const Trust& trust, const std::string& host) {
  auto made = std::make_unique<asio::ssl::context>(asio::ssl::context::tls_client);
  SSL_CTX* const context = made->native_handle();
  SSL_CTX_set_min_proto_version(context, TLS1_3_VERSION);
  SSL_CTX_set_alpn_protos(context, protocol::kAlpn.data(), protocol::kAlpn.size());
  SSL_CTX_set_verify(context, SSL_VERIFY_PEER, note_shown);
  if (!trust.pin.empty()) {
    const auto pin = read_pin(trust.pin);
    if (!pin) return pin.error();
    accept_pinned(context, *pin);
  } else if (auto accepted = accept_signed(context, trust, trust.fleet.empty() ? host : trust.fleet); !accepted) {
    return accepted.error();
  }
  if (auto shown = show_own(context, trust); !shown) return shown.error();
  return made;
}

}  // namespace gnomon::client
