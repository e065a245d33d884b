// Which clients are admitted, over real connections: tokens, certificates, versions; floods of connections and junk.
#include <random>

#include "daemon/net/demo_certificate.h"
#include "tests/unit/daemon/net/secure_served.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using protocol::RefusalCode;

TEST_F(Secure, TokensOpenTheirOwnTenant) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(hello("studio", "s")));
  c.send_view(1, 1);
  EXPECT_TRUE(is_frame_of(c, c.receive_frame(1), 1));
  EXPECT_EQ(refusal_of(hello("studio", "a")), RefusalCode::bad_token) << "another tenant's";
  EXPECT_EQ(refusal_of(hello("studio", "")), RefusalCode::bad_token);
  EXPECT_EQ(count_of(Fault::refused_bad_token), 2u);
  EXPECT_EQ(refusal_of(hello("nobody", "s")), RefusalCode::bad_token) << "which tenants there are is no stranger's";
  EXPECT_EQ(count_of(Fault::refused_unknown_tenant), 1u);
}

TEST_F(Secure, WhoShowsNothingIsToldSoWhetherThereIsSuchATenantOrNot) {
  start();
  const auto text_for = [&](const protocol::Hello& hello) {
    TestClient c = client();
    c.send(hello);
    const auto refused = c.receive_a<protocol::Refused>();
    return refused ? refused->text : "";
  };
  const std::string nothing_shown = text_for(hello("studio", ""));
  EXPECT_NE(nothing_shown.find("no token was sent"), std::string::npos) << nothing_shown;
  EXPECT_EQ(text_for(hello("nobody", "")), nothing_shown);
  EXPECT_EQ(text_for(hello("studio", "wrong")), "the token is not that of this tenant");
  EXPECT_EQ(text_for(hello("nobody", "wrong")), "the token is not that of this tenant");
}

TEST_F(Secure, AReloadTakesAwayAToken) {
  start();
  Config next = config_;
  next.tenants[0].token_sha256 = {hash_of("new")};
  ASSERT_TRUE(daemon_->reload(next));
  EXPECT_EQ(refusal_of(hello("studio", "s")), RefusalCode::bad_token);
  TestClient c = client();
  EXPECT_TRUE(c.join(hello("studio", "new")));
}

TEST_F(Secure, AClientCertificateStandsForAToken) {
  ask_for_client_certificates();
  start();
  TestClient c = client_with("studio", make("studio", Use::client, &authority_));
  EXPECT_TRUE(c.join(hello("", "")));
  TestClient other = client_with("arcade", make("arcade", Use::client, &authority_));
  other.send(hello("studio", ""));
  const auto refused = other.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, RefusalCode::bad_token);
  TestClient by_token = client();
  EXPECT_TRUE(by_token.join(hello("studio", "s"))) << "it is not asked for";
}

TEST_F(Secure, ACertificateThatIsNotGoodIsRefusedInTheHandshake) {
  ask_for_client_certificates();
  start();
  const Identity stranger = make("stranger", Use::authority, nullptr);
  const std::vector<std::pair<const char*, Identity>> bad = {
      {"expired", make("studio", Use::client, &authority_, -60s)},
      {"foreign", make("studio", Use::client, &stranger)},
      {"self_signed", make("studio", Use::client, nullptr)},
      {"server", make("studio", Use::server, &authority_)},
  };
  uint64_t refused = 0;
  for (const auto& [name, identity] : bad) {
    TestClient c = client_with(name, identity);
    EXPECT_FALSE(c.join(hello("studio", "s"))) << name << ": not even with a good token";
    ++refused;
    EXPECT_TRUE(eventually([&] { return count_of(Fault::tls_certificate) == refused; })) << name;
  }
  TestClient honest = client();
  EXPECT_TRUE(honest.join(hello("studio", "s")));
}

TEST_F(Secure, OlderTlsAndOtherProtocolsAreRefused) {
  start();
  TestClient old(daemon_->control_port(), [](SSL* tls) { SSL_set_max_proto_version(tls, TLS1_2_VERSION); });
  EXPECT_FALSE(old.shook_hands());
  EXPECT_TRUE(eventually([&] { return count_of(Fault::tls_version) == 1; }));
  TestClient other(daemon_->control_port(),
                   [](SSL* tls) { SSL_set_alpn_protos(tls, reinterpret_cast<const uint8_t*>("\x02h2"), 3); });
  EXPECT_FALSE(other.shook_hands());
  EXPECT_TRUE(eventually([&] { return count_of(Fault::tls_failed) == 1; }));
}

TEST_F(Secure, AVersionFromBeforeOrAfterOursIsRefusedWithItsCode) {
  start();
  for (const uint16_t version : {1, 3}) {
    protocol::Hello asks = hello("studio", "s");
    asks.version_min = asks.version_max = version;
    EXPECT_EQ(refusal_of(asks), RefusalCode::version) << version;
  }
  // The Hello of a version 1 client has another layout: its first three fields are enough to refuse it.
  std::vector<uint8_t> ancient = {16, 0, 0, 0, 1, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 2};
  TestClient c = client();
  c.send_bytes(ancient);
  const auto refused = c.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, RefusalCode::version);
}

TEST_F(Secure, DoesNotStartInsecurely) {
  config_.server.tls = {};
  EXPECT_NE(failure().find("gnomonctl make-certs --out DIR"), std::string::npos) << failure();
  config_.server.tls.certificate = folder_ / "server.pem";
  EXPECT_NE(failure().find("certificate and key are needed together"), std::string::npos);
  config_.server.tls.key = folder_ / "server-key.pem";
  chmod(config_.server.tls.key.c_str(), 0644);
  EXPECT_NE(failure().find("may be read by others"), std::string::npos) << failure();
  chmod(config_.server.tls.key.c_str(), 0600);
  EXPECT_EQ(failure(), "started");

  write_identity("other", make("other", Use::server, &authority_));
  config_.server.tls.key = folder_ / "other-key.pem";
  EXPECT_NE(failure().find("key values mismatch"), std::string::npos) << failure();
  config_.server.tls = {folder_ / "none.pem", folder_ / "server-key.pem", {}};
  EXPECT_NE(failure().find("server.tls.certificate"), std::string::npos) << failure();
  config_.server.tls = {folder_ / "server.pem", folder_ / "server-key.pem", folder_ / "none.pem"};
  EXPECT_NE(failure().find("server.tls.client_ca"), std::string::npos) << failure();
  config_.server.tls.client_ca.clear();
  config_.tenants.push_back({.name = "nobodys"});
  EXPECT_NE(failure().find("nobody could connect as nobodys"), std::string::npos) << failure();
}

TEST_F(Secure, AReloadReadsTheCertificatesAnewForNewConnections) {
  start();
  TestClient before = client();
  ASSERT_TRUE(before.join(hello("studio", "s")));
  write_identity("server", make("server", Use::server, &authority_));  // replaces the same files
  ask_for_client_certificates();
  ASSERT_TRUE(daemon_->reload(config_));
  TestClient after = client_with("studio", make("studio", Use::client, &authority_));
  EXPECT_NE(after.server_pin(), before.server_pin());
  EXPECT_EQ(after.server_pin(), daemon_->pin());
  ASSERT_TRUE(after.join(hello("", ""))) << "its certificate is asked for now";
  for (TestClient* c : {&before, &after}) {
    c->send_view(1, 1);
    EXPECT_TRUE(is_frame_of(*c, c->receive_frame(1), 1));
  }
}

// What counts is the address that it listens on, not one that a restart would bring.
TEST_F(Secure, AReloadLetsNoStrangersInFromElsewhereUnlessItSaysSo) {
  config_.server.listen = "0.0.0.0";
  start();
  Config next = config_;
  next.server.listen = "127.0.0.1";
  next.tenants[0].open = true;
  const auto refused = daemon_->reload(next);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("tenant studio is open"), std::string::npos) << refused.error().message;
  EXPECT_EQ(refusal_of(hello("studio", "guess")), RefusalCode::bad_token) << "the rest is applied, but this is not";
  next.server.insecure_listen = true;
  const auto allowed = daemon_->reload(next);
  ASSERT_FALSE(allowed);
  EXPECT_EQ(allowed.error().message.find("tenant studio is open"), std::string::npos) << allowed.error().message;
  EXPECT_NE(allowed.error().message.find("server.listen: changed, which takes a restart"), std::string::npos);
  TestClient stranger = client();
  EXPECT_TRUE(stranger.join(hello("studio", "guess")));
}

TEST_F(Secure, WhoServesStrangersFromElsewhereIsWarnedAtEachStart) {
  const auto log_of_start = [&] {
    testing::internal::CaptureStderr();
    start();
    daemon_.reset();
    return testing::internal::GetCapturedStderr();
  };
  config_.server.listen = "0.0.0.0";
  EXPECT_EQ(log_of_start().find("strangers are served"), std::string::npos);
  config_.server.insecure_listen = true;
  config_.tenants[1].open = true;
  for (int i = 0; i < 2; ++i) {
    const std::string log = log_of_start();
    EXPECT_NE(log.find("strangers are served"), std::string::npos) << log;
    EXPECT_NE(log.find("tenant arcade is open"), std::string::npos) << log;
  }
}

TEST_F(Secure, DemoModeKeepsItsCertificate) {
  config_.server.mode = ServerMode::demo;
  config_.server.tls = {};
  start();
  const protocol::Pin pin = daemon_->pin();
  daemon_.reset();
  start();
  EXPECT_EQ(daemon_->pin(), pin);
  struct stat info {};
  ASSERT_EQ(stat((folder_ / "state/demo.pem").c_str(), &info), 0);
  EXPECT_EQ(info.st_mode & 0777, 0600u);
  std::string shown;
  std::getline(std::ifstream(folder_ / "state/demo.pin"), shown);
  EXPECT_EQ(shown, protocol::to_string(pin));
}

TEST_F(Secure, AnAddressThatOpensConnectionAfterConnectionIsTurnedAway) {
  config_.server.max_sessions_per_address = 8;
  config_.server.connections_per_s = 1;
  start();
  asio::io_context io;
  std::vector<asio::ip::tcp::socket> flood;
  for (int i = 0; i < 200; ++i) {
    auto& socket = flood.emplace_back(io, asio::ip::tcp::endpoint(asio::ip::make_address("127.0.0.2"), 0));
    asio::error_code ignored;
    socket.connect({asio::ip::address_v4::loopback(), daemon_->control_port()}, ignored);
  }
  EXPECT_TRUE(eventually([&] { return count_of(Fault::connection_rate) > 100; }));
  TestClient honest = client();
  EXPECT_TRUE(honest.join(hello("studio", "s"))) << "from another address";
}

TEST_F(Secure, AFloodOfJunkIsCountedToTheLastDatagramAndHarmsNobody) {
  start();
  TestClient honest = client(), victim = client();
  ASSERT_TRUE(honest.join(hello("studio", "s")));
  ASSERT_TRUE(victim.join(hello("arcade", "a")));
  // Noise with the right version and kind; the victim's session with wrong tags; the honest client's datagrams under
  // the victim's session.
  std::mt19937 random(1);
  uint64_t sent = 0;
  const auto all_counted = [&] {
    return count_of(Fault::datagram_header) + count_of(Fault::datagram_session) +
               count_of(Fault::datagram_replayed) + count_of(Fault::datagram_forged) ==
           sent;
  };
  std::vector<uint8_t> forged = victim.sealed_view(1, 1);
  for (uint32_t round = 1; round <= 100; ++round) {
    for (int i = 0; i < 100; ++i) {
      std::vector<uint8_t> junk(36 + random() % 1100);
      for (uint8_t& byte : junk) byte = static_cast<uint8_t>(random());
      junk[0] = static_cast<uint8_t>(protocol::kVersion);
      junk[1] = 1;
      victim.send_datagram(junk);
      forged[20 + random() % (forged.size() - 20)] ^= static_cast<uint8_t>(1 + random() % 255);
      victim.send_datagram(forged);
      sent += 2;
    }
    auto spliced = honest.sealed_view(1000 + round, 1);
    std::copy_n(forged.begin() + 4, 8, spliced.begin() + 4);  // the victim's session
    victim.send_datagram(spliced);
    ++sent;
    honest.send_view(round, static_cast<float>(round));
    ASSERT_TRUE(is_frame_of(honest, honest.receive_frame(round), static_cast<float>(round)));
    ASSERT_TRUE(eventually(all_counted)) << daemon_->metrics().text();
  }
  victim.send_view(2, 3);
  EXPECT_TRUE(is_frame_of(victim, victim.receive_frame(2), 3));
  EXPECT_GE(count_of(Fault::datagram_forged), 10'000u);
}

}  // namespace
}  // namespace gnomon::daemon
