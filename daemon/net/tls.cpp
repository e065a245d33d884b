#include "daemon/net/tls.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509v3.h>

#include <algorithm>
#include <asio/ip/address.hpp>
#include <ctime>

#include "common/log.h"
#include "common/wall_clock.h"
#include "daemon/net/demo_certificate.h"
#include "daemon/security/private_file.h"
#include "protocol/messages.h"

namespace gnomon::daemon {
namespace {

namespace fs = std::filesystem;

constexpr const char* kCiphers = "TLS_AES_128_GCM_SHA256:TLS_CHACHA20_POLY1305_SHA256:TLS_AES_256_GCM_SHA384";
constexpr const char* kGroups = "X25519:P-256";

Error library_error(const std::string& what) {
  const char* const reason = ERR_reason_error_string(ERR_get_error());
  ERR_clear_error();
  return Error{what + ": " + (reason ? reason : "cannot be read")};
}

// In order of preference.
struct Protocols {
  const unsigned char* names;
  unsigned bytes;
};
constexpr unsigned char kWithBrowsers[] = "\6gnomon\10http/1.1";
constexpr Protocols kClients{protocol::kAlpn.data(), protocol::kAlpn.size()};
constexpr Protocols kClientsAndBrowsers{kWithBrowsers, sizeof kWithBrowsers - 1};

void harden(SSL_CTX* context, bool browsers) {
  SSL_CTX_set_min_proto_version(context, TLS1_3_VERSION);
  SSL_CTX_set_ciphersuites(context, kCiphers);
  SSL_CTX_set1_groups_list(context, kGroups);
  // TLS sessions are never resumed, so no tickets are issued and no session is cached.
  SSL_CTX_set_num_tickets(context, 0);
  SSL_CTX_set_session_cache_mode(context, SSL_SESS_CACHE_OFF);
  // A client without AES instructions prefers ChaCha20, which then takes precedence over our order.
  SSL_CTX_set_options(context, SSL_OP_CIPHER_SERVER_PREFERENCE | SSL_OP_PRIORITIZE_CHACHA | SSL_OP_NO_TICKET);
  SSL_CTX_set_mode(context, SSL_MODE_RELEASE_BUFFERS);  // connections are mostly idle
  SSL_CTX_set_alpn_select_cb(
      context,
      [](SSL*, const unsigned char** chosen, unsigned char* size, const unsigned char* offered,
         unsigned offered_size, void* ours) {
        const auto& spoken = *static_cast<const Protocols*>(ours);
        unsigned char* match = nullptr;
        const int found = SSL_select_next_proto(&match, size, spoken.names, spoken.bytes, offered, offered_size);
        *chosen = match;
        return found == OPENSSL_NPN_NEGOTIATED ? SSL_TLSEXT_ERR_OK : SSL_TLSEXT_ERR_ALERT_FATAL;
      },
      const_cast<Protocols*>(browsers ? &kClientsAndBrowsers : &kClients));  // it is only read
}

Result<void> use_identity(SSL_CTX* context, const TlsConfig& tls) {
  if (SSL_CTX_use_certificate_chain_file(context, tls.certificate.c_str()) != 1) {
    return library_error("server.tls.certificate: " + tls.certificate.string());
  }
  if (auto checked = check_private("server.tls.key", tls.key); !checked) return checked;
  if (SSL_CTX_use_PrivateKey_file(context, tls.key.c_str(), SSL_FILETYPE_PEM) != 1) {
    return library_error("server.tls.key: " + tls.key.string());
  }
  return {};
}

// Reads revocation lists into the store. A certificate whose authority has none there, or an outdated one, is refused.
Result<void> read_revocations(X509_STORE* store, const fs::path& lists) {
  if (lists.empty()) return {};
  X509_LOOKUP* const files = X509_STORE_add_lookup(store, X509_LOOKUP_file());
  if (!files || X509_load_crl_file(files, lists.c_str(), X509_FILETYPE_PEM) < 1) {
    return library_error("server.tls.client_crl: " + lists.string());
  }
  X509_STORE_set_flags(store, X509_V_FLAG_CRL_CHECK | X509_V_FLAG_CRL_CHECK_ALL);
  return {};
}

// Clients may show a certificate; if they do, one of the authorities must have signed it.
Result<void> ask_clients(SSL_CTX* context, const TlsConfig& tls) {
  if (tls.client_ca.empty()) return {};
  STACK_OF(X509_NAME)* const names = SSL_load_client_CA_file(tls.client_ca.c_str());
  if (!names || SSL_CTX_load_verify_file(context, tls.client_ca.c_str()) != 1) {
    sk_X509_NAME_pop_free(names, X509_NAME_free);
    return library_error("server.tls.client_ca: " + tls.client_ca.string());
  }
  SSL_CTX_set_client_CA_list(context, names);
  if (auto read = read_revocations(SSL_CTX_get_cert_store(context), tls.client_crl); !read) return read;
  SSL_CTX_set_verify(context, SSL_VERIFY_PEER, nullptr);
  return {};
}

void ask_clients_as(SSL_CTX* context, SSL_CTX* before) {
  SSL_CTX_set1_cert_store(context, SSL_CTX_get_cert_store(before));
  SSL_CTX_set_client_CA_list(context, SSL_dup_CA_list(SSL_CTX_get_client_CA_list(before)));
  SSL_CTX_set_verify(context, SSL_CTX_get_verify_mode(before), nullptr);
}

// Precondition: `before` has an identity.
void use_identity_of(SSL_CTX* context, SSL_CTX* before) {
  STACK_OF(X509)* chain = nullptr;
  SSL_CTX_get0_chain_certs(before, &chain);
  SSL_CTX_use_cert_and_key(context, SSL_CTX_get0_certificate(before), SSL_CTX_get0_privatekey(before), chain, 1);
}

std::string in_utc(std::chrono::sys_seconds time) {
  const std::time_t seconds = time.time_since_epoch().count();
  std::tm calendar{};
  gmtime_r(&seconds, &calendar);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &calendar);
  return text;
}

std::shared_ptr<Tls> hardened(bool browsers) {
  auto tls = std::make_shared<Tls>();
  harden(tls->context.native_handle(), browsers);
  tls->browsers = browsers;
  return tls;
}

std::string address_of(const ASN1_OCTET_STRING* address) {
  const unsigned char* const bytes = ASN1_STRING_get0_data(address);
  asio::ip::address_v4::bytes_type v4;
  asio::ip::address_v6::bytes_type v6;
  const auto size = static_cast<size_t>(ASN1_STRING_length(address));
  if (size == v4.size()) {
    std::copy_n(bytes, v4.size(), v4.begin());
    return asio::ip::address_v4(v4).to_string();
  }
  if (size != v6.size()) return {};
  std::copy_n(bytes, v6.size(), v6.begin());
  return asio::ip::address_v6(v6).to_string();
}

// The names and addresses that the certificate is for (RFC 9525: subjectAltName alone).
std::vector<std::string> hosts_of(X509* certificate) {
  std::vector<std::string> hosts;
  auto* const names =
      static_cast<GENERAL_NAMES*>(X509_get_ext_d2i(certificate, NID_subject_alt_name, nullptr, nullptr));
  for (int i = 0; i < sk_GENERAL_NAME_num(names); ++i) {
    const GENERAL_NAME* const name = sk_GENERAL_NAME_value(names, i);
    if (name->type == GEN_IPADD) hosts.push_back(address_of(name->d.iPAddress));
    if (name->type != GEN_DNS) continue;
    const ASN1_STRING* const text = name->d.dNSName;
    hosts.emplace_back(reinterpret_cast<const char*>(ASN1_STRING_get0_data(text)),
                       static_cast<size_t>(ASN1_STRING_length(text)));
  }
  GENERAL_NAMES_free(names);
  std::erase(hosts, "");
  return hosts;
}

// Notes what others ask of a complete context.
void describe(Tls& tls) {
  SSL_CTX* const context = tls.context.native_handle();
  tls.pin = protocol::pin_of(SSL_CTX_get0_certificate(context));
  tls.names = hosts_of(SSL_CTX_get0_certificate(context));
  tls.expires = end_of(SSL_CTX_get0_certificate(context));
  tls.authorities = authorities_in(SSL_CTX_get_cert_store(context));
}

Result<TlsConfig> files_of(const ServerConfig& config) {
  if (!config.tls.certificate.empty() && !config.tls.key.empty()) return config.tls;
  if (!config.tls.certificate.empty() || !config.tls.key.empty()) {
    return Error{"server.tls: certificate and key are needed together; only one of them is set"};
  }
  if (config.mode == ServerMode::demo) return demo_certificate(config);
  return Error{
      "server.tls.certificate: none is set, and without one nobody could know that it is this server they speak "
      "to. "
      "Make certificates with\n  gnomonctl make-certs --out DIR --host NAME\nand set server.tls.certificate: "
      "DIR/server.pem and server.tls.key: DIR/server-key.pem; or, to try Gnomon out on this machine, set "
      "server.mode: "
      "demo"};
}

}  // namespace

Result<std::shared_ptr<Tls>> open_tls(const ServerConfig& config, bool browsers) {
  const auto files = files_of(config);
  if (!files) return files.error();
  auto tls = hardened(browsers);
  SSL_CTX* const context = tls->context.native_handle();
  if (auto used = use_identity(context, *files); !used) return used.error();
  if (auto asked = ask_clients(context, *files); !asked) return asked.error();
  describe(*tls);
  return tls;
}

ReopenedTls reopen_tls(const ServerConfig& config, const Tls& before) {
  SSL_CTX* const old = const_cast<Tls&>(before).context.native_handle();  // it is only read
  ReopenedTls reopened{hardened(before.browsers), {}};
  const auto keep_identity = [&](const Error& why) {
    reopened.kept.push_back(why);
    reopened.tls = hardened(before.browsers);  // without what was read of another one
    use_identity_of(reopened.tls->context.native_handle(), old);
  };
  const auto files = files_of(config);
  if (!files) {
    keep_identity(files.error());
  } else if (auto used = use_identity(reopened.tls->context.native_handle(), *files); !used) {
    keep_identity(used.error());
  } else if (const auto why = out_of_date(files->certificate, *reopened.tls, wall_now()); !why.empty()) {
    keep_identity(Error{why});
  }
  SSL_CTX* const context = reopened.tls->context.native_handle();
  if (auto asked = ask_clients(context, config.tls); !asked) {
    reopened.kept.push_back(asked.error());
    ask_clients_as(context, old);
  }
  describe(*reopened.tls);
  return reopened;
}

std::string out_of_date(const fs::path& file, const Tls& tls, std::chrono::sys_seconds now) {
  SSL_CTX* const context = const_cast<Tls&>(tls).context.native_handle();  // it is only read
  const X509* const certificate = SSL_CTX_get0_certificate(context);
  const std::string named = "server.tls.certificate: " + file.string();
  if (end_of(certificate) <= now)
    return named + " has expired: clients refuse it; make another with gnomonctl make-certs";
  const auto begin = begin_of(certificate);
  return begin <= now ? "" : named + " is not valid before " + in_utc(begin) + ": clients refuse it until then";
}

FirstExpiry first_expiry(const Tls& tls) {
  if (tls.authorities.expires < tls.expires) return {"server.tls.client_ca", tls.authorities.expires};
  return {"server.tls.certificate", tls.expires};
}

}  // namespace gnomon::daemon
