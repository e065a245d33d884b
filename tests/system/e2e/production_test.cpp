// gnomond as it is meant to stand in the open: certificates of gnomonctl make-certs, tenants' tokens and certificates.
// Who belongs here gets frames; who does not is refused with the right word, and counted under it.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "daemon/security/certificates.h"
#include "tests/system/e2e/daemon.h"
#include "tests/unit/daemon/net/test_client.h"

namespace gnomon::tests {
namespace {

namespace fs = std::filesystem;
using daemon::CertificateOptions;
using daemon::Identity;
using daemon::TestClient;
using protocol::RefusalCode;
using namespace std::chrono_literals;

class Production : public testing::Test {
 protected:
  // studio has a token, arcade a certificate.
  void SetUp() override {
    const auto [status, output] =
        run("gnomonctl", {"make-certs", "--out", certs().string(), "--host", "127.0.0.1", "--client", "arcade"});
    ASSERT_EQ(status, 0) << output;
    const auto [made, token] = run("gnomonctl", {"make-token"});
    ASSERT_EQ(made, 0) << token;
    std::istringstream words(token);
    std::string name, hash;
    words >> name >> token_ >> name >> hash;
    std::ofstream(token_file()) << token_ << "\n";
    std::ofstream(folder_.path() / "wrong.token") << hash << "\n";
    daemon_.emplace(config(hash));
    ASSERT_NE(daemon_->address().port, 0);
  }

  fs::path certs() const { return folder_.path() / "certs"; }
  fs::path cert(const std::string& name) const { return certs() / (name + ".pem"); }
  fs::path token_file() const { return folder_.path() / "studio.token"; }

  std::string config(const std::string& token_hash) const {
    return "server: {mode: production, listen: 127.0.0.1, control_port: 0, data_port: 0, drain_timeout_ms: 2000,\n"
           "  tls: {certificate: " +
           cert("server").string() + ", key: " + cert("server-key").string() +
           ", client_ca: " + cert("ca").string() +
           "}}\n"
           "admin: {listen: 127.0.0.1, port: 0}\n"
           "render: {device: cpu}\n"
           "scenes: {list: [{name: living_room, file: living_room.glb}]}\n"
           "tenants: [{name: studio, token_sha256: [" +
           token_hash + "]}, {name: arcade}]\n";
  }

  // gnomon-client asks for one frame; `more`: how it knows the server, and what it shows of itself.
  Finished fly(std::vector<std::string> more) const {
    more.insert(more.end(), {"--server", daemon_->server(), "--scene", "living_room", "--size", "160x90",
                             "--frames", "2", "--json", report().string()});
    return run("gnomon-client", more);
  }

  fs::path report() const { return folder_.path() / "client.json"; }
  std::vector<std::string> by_token() const {
    return {"--ca", cert("ca").string(), "--tenant", "studio", "--token-file", token_file().string()};
  }

  void expect_frames(const Finished& flight) const {
    ASSERT_EQ(flight.status, 0) << flight.output;
    const auto row = nlohmann::json::parse(read_file(report()))["rows"][0];
    EXPECT_GE(row["frames"].get<int>(), 1);
    EXPECT_EQ(row["invalid_slices"], 0);
  }

  // One line with those words; and one more is counted under that reason.
  void expect_refused(const std::vector<std::string>& arguments, const std::string& words,
                      const std::string& reason) const {
    const double before = refusals(reason);
    const Finished flight = fly(arguments);
    EXPECT_EQ(flight.status, 1) << flight.output;
    EXPECT_NE(flight.output.find(words), std::string::npos) << flight.output;
    EXPECT_TRUE(eventually([&] { return refusals(reason) == before + 1; })) << reason << daemon_->page("/metrics");
  }

  double refusals(const std::string& reason) const {
    return daemon_->metric("gnomon_refusals_total", {"reason=\"" + reason + "\""});
  }

  // As gnomonctl makes one for arcade, but one that lasts so long.
  std::vector<std::string> certificate_of_arcade(std::chrono::seconds lasts) const {
    const Identity authority{read_file(cert("ca")), read_file(cert("ca-key"))};
    CertificateOptions options{.name = "arcade", .hosts = {}, .use = CertificateOptions::Use::client};
    options.lasts = lasts;
    const Identity made = daemon::make_certificate(options, &authority).value();
    const fs::path file = folder_.path() / "arcade.pem", key = folder_.path() / "arcade-key.pem";
    std::ofstream(file) << made.certificate;
    std::ofstream(key) << made.key;
    return {"--ca", cert("ca").string(), "--certificate", file.string(), "--key", key.string()};
  }

  TemporaryFolder folder_;
  std::string token_;
  std::optional<Daemon> daemon_;
};

TEST_F(Production, TokensAndCertificatesAreGoodForFrames) {
  expect_frames(fly(by_token()));
  expect_frames(fly(certificate_of_arcade(1h)));
  expect_frames(fly({"--pin", daemon_->pin(), "--tenant", "studio", "--token-file", token_file().string()}));
  EXPECT_EQ(daemon_->metric("gnomon_refusals_total", {"reason=\"bad_token\""}), 0);
}

TEST_F(Production, StrangersAreRefusedEachWithItsWordAndCounted) {
  const std::string ca = cert("ca").string(), wrong_token = (folder_.path() / "wrong.token").string();
  expect_refused({"--ca", ca, "--tenant", "studio", "--token-file", wrong_token}, "refused (bad_token)",
                 "bad_token");
  expect_refused({"--ca", ca, "--tenant", "arcade", "--token-file", token_file().string()}, "refused (bad_token)",
                 "bad_token");
  expect_refused({"--ca", ca, "--tenant", "nobody", "--token-file", token_file().string()}, "refused (bad_token)",
                 "unknown_tenant");
  auto another_tenants = certificate_of_arcade(1h);
  another_tenants.insert(another_tenants.end(), {"--tenant", "studio"});
  expect_refused(another_tenants, "refused (bad_token)", "bad_token");
  expect_refused(certificate_of_arcade(-60s), "certificate expired", "tls_certificate");
  // The client it is that refuses a server with another certificate, before it has said who it is.
  expect_refused(
      {"--pin", "sha256:" + std::string(64, '0'), "--tenant", "studio", "--token-file", token_file().string()},
      "it is not the one expected", "tls_distrusted");
  expect_frames(fly(by_token()));
}

TEST_F(Production, OlderVersionsAreRefused) {
  TestClient old_tls(daemon_->address().port, [](SSL* tls) { SSL_set_max_proto_version(tls, TLS1_2_VERSION); });
  EXPECT_FALSE(old_tls.shook_hands());
  EXPECT_TRUE(eventually([&] { return refusals("tls_version") == 1; }));
  TestClient old_client(daemon_->address().port);
  protocol::Hello hello = TestClient::hello("living_room");
  hello.version_min = hello.version_max = protocol::kVersion - 1;
  hello.tenant = "studio";
  hello.token = token_;
  old_client.send(hello);
  const auto refused = old_client.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, RefusalCode::version);
  EXPECT_EQ(refusals("version"), 1);
}

TEST_F(Production, RenewedCertificatesAreTakenUpWithoutARestart) {
  const auto hello = [&] {
    protocol::Hello made = TestClient::hello("living_room");
    made.tenant = "studio";
    made.token = token_;
    return made;
  };
  TestClient before(daemon_->address().port);
  ASSERT_TRUE(before.join(hello()));
  const auto renew = run("gnomonctl", {"make-certs", "--out", certs().string(), "--host", "127.0.0.1", "--renew"});
  ASSERT_EQ(renew.status, 0) << renew.output;
  daemon_->process().signal(SIGHUP);
  ASSERT_TRUE(eventually([&] { return daemon_->metric("gnomon_config_reloads_total", {"result=\"done\""}) == 1; }));
  TestClient after(daemon_->address().port);
  EXPECT_NE(after.server_pin(), before.server_pin());
  ASSERT_TRUE(after.join(hello()));

  std::ofstream(cert("server")) << "half a certificate";
  EXPECT_EQ(daemon_->post("/reload", "{}").find(" 200"), std::string::npos);
  EXPECT_EQ(TestClient(daemon_->address().port).server_pin(), after.server_pin());
  for (TestClient* client : {&before, &after}) {
    client->send_view(1, 1);
    EXPECT_FALSE(client->receive_frame(1).empty());
  }
  expect_frames(fly(by_token()));  // last, as it may take longer than a server waits for clients that are silent
}

}  // namespace
}  // namespace gnomon::tests
