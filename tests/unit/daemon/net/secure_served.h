// A daemon in mode production, with certificates and tokens that the test makes.
#pragma once

#include <sys/stat.h>

#include "daemon/security/certificates.h"
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {

class Secure : public Served {
 protected:
  void SetUp() override {
    Served::SetUp();
    config_.server.mode = ServerMode::production;
    config_.server.tls = {write_identity("server", server_), folder_ / "server-key.pem", {}};
    config_.tenants = {{.name = "studio", .token_sha256 = {hash_of("s")}},
                       {.name = "arcade", .token_sha256 = {hash_of("a")}}};
  }

  using Use = CertificateOptions::Use;

  std::filesystem::path write_identity(const std::string& name, const Identity& identity) {
    const auto key = folder_ / (name + "-key.pem"), certificate = folder_ / (name + ".pem");
    std::ofstream(key) << identity.key;
    chmod(key.c_str(), 0600);
    std::ofstream(certificate) << identity.certificate;
    return certificate;
  }

  static Identity make(const std::string& name, Use use, const Identity* issuer,
                       std::chrono::seconds lasts = std::chrono::hours(1)) {
    CertificateOptions options{.name = name, .hosts = {}, .use = use};
    options.lasts = lasts;
    return make_certificate(options, issuer).value();
  }

  void ask_for_client_certificates() {
    write_identity("ca", authority_);
    config_.server.tls.client_ca = folder_ / "ca.pem";
  }

  // A client that shows this certificate.
  TestClient client_with(const std::string& name, const Identity& identity) {
    write_identity(name, identity);
    return TestClient(daemon_->control_port(), [&](SSL* tls) {
      SSL_use_certificate_file(tls, (folder_ / (name + ".pem")).c_str(), SSL_FILETYPE_PEM);
      SSL_use_PrivateKey_file(tls, (folder_ / (name + "-key.pem")).c_str(), SSL_FILETYPE_PEM);
    });
  }

  static protocol::Hello hello(const std::string& tenant, const std::string& token) {
    protocol::Hello hello = TestClient::hello(kScene);
    hello.tenant = tenant;
    hello.token = token;
    return hello;
  }

  std::optional<protocol::RefusalCode> refusal_of(const protocol::Hello& hello) {
    TestClient c = client();
    c.send(hello);
    const auto refused = c.receive_a<protocol::Refused>();
    return refused ? std::optional(refused->code) : std::nullopt;
  }

  std::string failure() {
    const auto daemon = try_start();
    return daemon ? "started" : daemon.error().message;
  }

  Identity authority_ = make("authority", Use::authority, nullptr);
  Identity server_ = make("server", Use::server, &authority_);
};

}  // namespace gnomon::daemon
