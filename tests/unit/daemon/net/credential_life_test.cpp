// How the life of a credential ends, over real connections: revoked, expired, too old; and reloads of which a part cannot
// be applied.
#include <openssl/pem.h>
#include <openssl/x509.h>

#include "common/wall_clock.h"
#include "tests/unit/daemon/net/secure_served.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using protocol::RefusalCode;

class CredentialLife : public Secure {
 protected:
  static protocol::Hello resumable(const std::string& tenant, const std::string& token) {
    protocol::Hello hello = Secure::hello(tenant, token);
    hello.features |= protocol::kFeatureResume;
    return hello;
  }

  // Why the session ended, as its client is told; empty if it was not.
  static std::string farewell(TestClient& client) {
    const auto bye = client.receive_a<protocol::Bye>();
    return bye ? bye->reason : "";
  }

  bool is_served(TestClient& client, uint32_t frame) {
    client.send_view(frame, 1);
    return is_frame_of(client, client.receive_frame(frame), 1);
  }

  std::string reload(const Config& next, std::vector<Error> missing = {}) {
    const auto done = daemon_->reload(next, "operator", std::move(missing));
    return done ? "reloaded" : done.error().message;
  }

  // Writes a list of the authority that revokes the certificate, or one that revokes nothing.
  std::filesystem::path write_revocations(const Identity* revoked) {
    const auto read = [](const std::string& pem, auto parse) {
      BIO* const bio = BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size()));
      auto* const object = parse(bio);
      BIO_free(bio);
      return object;
    };
    const auto certificate = [](BIO* bio) { return PEM_read_bio_X509(bio, nullptr, nullptr, nullptr); };
    X509* const issuer = read(authority_.certificate, certificate);
    EVP_PKEY* const key =
        read(authority_.key, [](BIO* bio) { return PEM_read_bio_PrivateKey(bio, nullptr, nullptr, nullptr); });
    X509_CRL* const list = X509_CRL_new();
    X509_CRL_set_version(list, 1);
    X509_CRL_set_issuer_name(list, X509_get_subject_name(issuer));
    ASN1_TIME* const time = X509_gmtime_adj(nullptr, -60);
    X509_CRL_set1_lastUpdate(list, time);
    if (revoked) {
      X509* const gone = read(revoked->certificate, certificate);
      X509_REVOKED* const entry = X509_REVOKED_new();
      X509_REVOKED_set_serialNumber(entry, X509_get_serialNumber(gone));
      X509_REVOKED_set_revocationDate(entry, time);
      X509_CRL_add0_revoked(list, entry);
      X509_free(gone);
    }
    X509_CRL_set1_nextUpdate(list, X509_gmtime_adj(time, 3600));
    X509_CRL_sign(list, key, EVP_sha256());
    const auto file = folder_ / "crl.pem";
    BIO* const out = BIO_new_file(file.c_str(), "w");
    PEM_write_bio_X509_CRL(out, list);
    BIO_free(out);
    ASN1_TIME_free(time);
    X509_CRL_free(list);
    EVP_PKEY_free(key);
    X509_free(issuer);
    return file;
  }
};

TEST_F(CredentialLife, AReloadEndsTheSessionsOfARevokedToken) {
  config_.tenants[0].token_sha256.push_back(hash_of("another"));
  start();
  TestClient revoked = client(), kept = client(), other = client(), back = client();
  ASSERT_TRUE(revoked.join(resumable("studio", "s")));
  ASSERT_TRUE(kept.join(resumable("studio", "another")));
  ASSERT_TRUE(other.join(resumable("arcade", "a")));
  Config next = config_;
  next.tenants[0].token_sha256 = {hash_of("another")};
  EXPECT_EQ(reload(next), "reloaded");
  EXPECT_EQ(farewell(revoked), "its token was revoked");
  EXPECT_FALSE(back.resume(revoked)) << "nor is it resumed";
  EXPECT_EQ(back.refused().code, RefusalCode::unknown_session);
  EXPECT_TRUE(is_served(kept, 1));
  EXPECT_TRUE(is_served(other, 1));
}

TEST_F(CredentialLife, WhoResumedASessionLosesItWithTheTokenThatOpenedIt) {
  start();
  TestClient first = client(), second = client();
  ASSERT_TRUE(first.join(resumable("studio", "s")));
  first.lose_control();
  ASSERT_TRUE(second.resume(first)) << "which needs no token";
  Config next = config_;
  next.tenants[0].token_sha256 = {hash_of("new")};
  EXPECT_EQ(reload(next), "reloaded");
  EXPECT_EQ(farewell(second), "its token was revoked");
}

TEST_F(CredentialLife, ACertificateThatExpiresEndsItsSession) {
  ask_for_client_certificates();
  start();
  TestClient brief = client_with("studio", make("studio", Use::client, &authority_, 3s));
  ASSERT_TRUE(brief.join(hello("", "")));
  EXPECT_EQ(farewell(brief), "its certificate has expired");
}

TEST_F(CredentialLife, ARevokedCertificateEndsItsSessionAndOpensNoOther) {
  ask_for_client_certificates();
  config_.server.tls.client_crl = write_revocations(nullptr);
  start();
  const Identity stolen = make("studio", Use::client, &authority_);
  TestClient thief = client_with("stolen", stolen);
  TestClient honest = client_with("studio", make("studio", Use::client, &authority_));
  ASSERT_TRUE(thief.join(hello("", "")));
  ASSERT_TRUE(honest.join(hello("", "")));
  write_revocations(&stolen);
  EXPECT_EQ(reload(config_), "reloaded");
  EXPECT_EQ(farewell(thief), "its certificate was revoked");
  EXPECT_TRUE(is_served(honest, 1));
  TestClient again = client_with("stolen", stolen);
  EXPECT_FALSE(again.join(hello("", "")));
}

TEST_F(CredentialLife, AnAuthorityThatIsNoLongerTrustedTakesItsSessionsAlong) {
  ask_for_client_certificates();
  start();
  TestClient c = client_with("studio", make("studio", Use::client, &authority_));
  ASSERT_TRUE(c.join(hello("", "")));
  EXPECT_EQ(reload(config_), "reloaded");
  EXPECT_TRUE(is_served(c, 1)) << "the same authority, read again";
  write_identity("ca", make("another", Use::authority, nullptr));
  EXPECT_EQ(reload(config_), "reloaded");
  EXPECT_EQ(farewell(c), "the authority of its certificate is no longer trusted");
}

TEST_F(CredentialLife, ASessionMayHaveAnAge) {
  config_.server.max_session_age = 1s;
  start();
  TestClient c = client(), next = client();
  ASSERT_TRUE(c.join(resumable("studio", "s")));
  EXPECT_EQ(farewell(c), "it is older than 1 s: authenticate anew");
  EXPECT_TRUE(next.join(hello("studio", "s")));
}

TEST_F(CredentialLife, AReloadAppliesWhatItCanAndSaysWhatItCannot) {
  start();
  const protocol::Pin pin = daemon_->pin();
  TestClient revoked = client(), kept = client();
  ASSERT_TRUE(revoked.join(hello("studio", "s")));
  ASSERT_TRUE(kept.join(hello("arcade", "a")));
  Config next = config_;
  next.tenants[0].token_sha256 = {hash_of("new")};
  write_identity("server", make("server", Use::server, &authority_, -60s));
  const std::string why = reload(next, {Error{"edge.yaml:3: file none.glb does not exist"}});
  EXPECT_NE(why.find("server.tls.certificate: "), std::string::npos) << why;
  EXPECT_NE(why.find("has expired"), std::string::npos) << why;
  EXPECT_NE(why.find("edge.yaml:3: file none.glb"), std::string::npos) << why;
  EXPECT_EQ(farewell(revoked), "its token was revoked");
  EXPECT_TRUE(is_served(kept, 1));
  TestClient after = client();
  EXPECT_EQ(after.server_pin(), pin) << "the certificate stays as it was";
  EXPECT_TRUE(after.join(hello("studio", "new")));
  EXPECT_TRUE(metrics_say("gnomon_config_reloads_total{result=\"failed\"} 1"));
}

TEST_F(CredentialLife, EachPartOfWhatIsReadForTlsStaysAsItWasByItself) {
  ask_for_client_certificates();
  start();
  TestClient before = client_with("studio", make("studio", Use::client, &authority_));
  ASSERT_TRUE(before.join(hello("", "")));
  const protocol::Pin pin = daemon_->pin();
  write_identity("server", make("server", Use::server, &authority_));
  std::ofstream(folder_ / "ca.pem") << "half an authority";
  EXPECT_NE(reload(config_).find("server.tls.client_ca"), std::string::npos);
  EXPECT_NE(daemon_->pin(), pin) << "the new certificate holds";
  EXPECT_TRUE(is_served(before, 1));
  TestClient after = client_with("studio", make("studio", Use::client, &authority_));
  EXPECT_TRUE(after.join(hello("", ""))) << "and so does the authority from before";
  const protocol::Pin second = daemon_->pin();
  for (const char* broken : {"half a certificate", ""}) {
    std::ofstream(folder_ / "server.pem") << broken;
    EXPECT_NE(reload(config_).find("server.tls.certificate"), std::string::npos);
    EXPECT_EQ(daemon_->pin(), second);
  }
  Config next = config_;
  next.server.tls = {};
  EXPECT_NE(reload(next).find("gnomonctl make-certs"), std::string::npos);
  TestClient last = client();
  EXPECT_EQ(last.server_pin(), second);
  EXPECT_TRUE(last.join(hello("studio", "s")));
}

TEST_F(CredentialLife, ATenantWhoseLastTokenIsRevokedIsClosedToAll) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(hello("studio", "s")));
  Config next = config_;
  next.tenants[0].token_sha256.clear();
  EXPECT_NE(reload(next).find("nobody could connect as studio"), std::string::npos);
  EXPECT_EQ(farewell(c), "its token was revoked");
  EXPECT_EQ(refusal_of(hello("studio", "s")), RefusalCode::bad_token);
}

TEST_F(CredentialLife, ADaemonStartsWithAnExpiredCertificateAndSaysSo) {
  write_identity("server", make("server", Use::server, &authority_, -60s));
  testing::internal::CaptureStderr();
  start();
  EXPECT_NE(testing::internal::GetCapturedStderr().find("has expired: clients refuse it"), std::string::npos);
  const protocol::Pin pin = daemon_->pin();
  write_identity("server", make("server", Use::server, &authority_));
  EXPECT_EQ(reload(config_), "reloaded") << "and can be given another one";
  EXPECT_NE(daemon_->pin(), pin);
}

TEST_F(CredentialLife, AReloadTakesNoCertificateThatIsNotValidYet) {
  start();
  const protocol::Pin pin = daemon_->pin();
  CertificateOptions tomorrow{.name = "server", .hosts = {}, .use = Use::server};
  tomorrow.starts_in = 24h;
  tomorrow.lasts = 48h;
  write_identity("server", make_certificate(tomorrow, &authority_).value());
  EXPECT_NE(reload(config_).find("server.pem is not valid before 20"), std::string::npos);
  EXPECT_EQ(daemon_->pin(), pin);
}

TEST_F(CredentialLife, OperatorsSeeWhenTheFirstCertificateExpires) {
  write_identity("server", make("server", Use::server, &authority_, 20 * 24h + 1h));
  start();
  testing::internal::CaptureStderr();
  daemon_->remind(wall_now());
  daemon_->remind(wall_now());
  const std::string log = testing::internal::GetCapturedStderr();
  const size_t first = log.find("a certificate expires soon key=server.tls.certificate days_left=20");
  EXPECT_NE(first, std::string::npos) << log;
  EXPECT_EQ(log.find("a certificate expires soon", first + 1), std::string::npos) << "once a day";
  const std::string metrics = daemon_->metrics().text();
  const std::string name = "\ngnomon_certificate_expiry_timestamp_seconds ";
  ASSERT_NE(metrics.find(name), std::string::npos);
  const double at = std::stod(metrics.substr(metrics.find(name) + name.size()));
  EXPECT_NEAR(at, static_cast<double>((wall_now() + 20 * 24h).time_since_epoch().count()), 7200);
}

}  // namespace
}  // namespace gnomon::daemon
