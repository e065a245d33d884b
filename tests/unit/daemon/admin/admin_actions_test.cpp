// Operators' actions on a running daemon, through the library behind gnomonctl.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "daemon/ctl/admin_client.h"
#include "daemon/ctl/top_tables.h"
#include "daemon/ctl/views.h"
#include "daemon/security/certificates.h"
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

class AdminActions : public Served {
 protected:
  // As an operator of this machine; the test runs as the account that the daemon has.
  ctl::AdminClient admin() { return ctl::AdminClient({.address = "unix:" + daemon_->admin().socket().string()}); }
  ctl::AdminClient over_tcp(const std::string& token = {}) {
    return ctl::AdminClient(
        {.address = "http://127.0.0.1:" + std::to_string(daemon_->admin().port()), .token = token});
  }
  static std::string refusal(ctl::AdminClient client, const std::string& path) {
    const auto answer = client.post(path);
    return answer ? "done: " + *answer : answer.error().message;
  }
  std::string only_session() {
    std::string id;
    EXPECT_TRUE(eventually([&] {
      const auto sessions = admin().status()->at("sessions");
      if (sessions.size() == 1) id = sessions[0].at("id");
      return !id.empty();
    }));
    return id;
  }
  void write_token(const std::string& text) {
    config_.admin.token_file = folder_ / "token";
    std::ofstream(config_.admin.token_file) << text;
    chmod(config_.admin.token_file.c_str(), 0600);
  }
  std::string refusal_of(const std::string& path) { return refusal(admin(), path); }
};

TEST_F(AdminActions, AKickedClientIsToldWhyAndItsSessionIsGone) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  const std::string path = "/sessions/" + only_session() + "/kick";
  const auto answer = admin().post(path, {{"why", "too loud"}});
  ASSERT_TRUE(answer) << answer.error().message;
  const auto bye = c.receive_a<protocol::Bye>();
  ASSERT_TRUE(bye);
  EXPECT_EQ(bye->reason, "too loud");
  EXPECT_EQ(refusal_of(path), "no such session");
  EXPECT_EQ(refusal_of("/sessions/99999999999999999999999/kick"), "no such session");
}

// Tenants are told apart, whose clients may share an address; the wire client's session_test has the time.
TEST_F(AdminActions, AKickedClientStaysOutForItsTime) {
  config_.tenants = {{.name = "default"}, {.name = "another"}};
  start();
  const auto kick = [&](const nlohmann::json& how) {
    TestClient c = client();
    EXPECT_TRUE(c.join(TestClient::hello(kScene)));
    EXPECT_TRUE(admin().post("/sessions/" + only_session() + "/kick", how));
    EXPECT_TRUE(eventually([&] { return admin().status()->at("sessions").empty(); }));
    return c.receive_a<protocol::Bye>();
  };
  EXPECT_EQ(kick({{"for_s", 0}})->stay_out_ms, 0u);
  EXPECT_EQ(kick({{"for_s", 3600}, {"why", "too loud"}})->stay_out_ms, 3'600'000u);
  TestClient again = client();
  again.send(TestClient::hello(kScene));
  const auto refused = again.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, protocol::RefusalCode::kept_out);
  EXPECT_EQ(refused->text.find("kept out for another 3"), 0u) << refused->text;
  EXPECT_NE(refused->text.find(" s: too loud"), std::string::npos) << refused->text;
  EXPECT_EQ(count_of(Fault::refused_kept_out), 1u);
  protocol::Hello other = TestClient::hello(kScene);
  other.tenant = "another";
  EXPECT_TRUE(client().join(other));
}

TEST_F(AdminActions, AKickWithoutATimeKeepsItsClientOutForAMinute) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  const std::string path = "/sessions/" + only_session() + "/kick";
  for (const nlohmann::json& wrong : {nlohmann::json(-1), nlohmann::json("60"), nlohmann::json(604801)}) {
    const auto answer = admin().post(path, {{"for_s", wrong}});
    ASSERT_FALSE(answer) << wrong;
    EXPECT_NE(answer.error().message.find("for_s"), std::string::npos);
  }
  const auto answer = admin().post(path);
  ASSERT_TRUE(answer) << answer.error().message;
  EXPECT_EQ(*answer, "closed; its client stays out for 60 s");
  EXPECT_EQ(c.receive_a<protocol::Bye>()->stay_out_ms, 60'000u);
}

TEST_F(AdminActions, ASceneIsUnloadedWhenNobodyUsesItAndComesBackFromItsFile) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  EXPECT_EQ(refusal_of("/scenes/triangle/unload"), "sessions use it: 1");
  c.send_view(1, 1);
  EXPECT_FALSE(c.receive_frame(1).empty());
  c.send(protocol::Bye{});
  ASSERT_TRUE(eventually([&] { return admin().status()->at("scenes")[0].at("sessions") == 0; }));
  ASSERT_TRUE(admin().post("/scenes/triangle/unload"));
  EXPECT_TRUE(admin().status()->at("scenes").empty());
  EXPECT_TRUE(metrics_say("gnomon_scene_resident{scene=\"triangle\"} 0"));
  EXPECT_EQ(refusal_of("/scenes/triangle/unload"), "no such scene is resident");

  ASSERT_TRUE(admin().post("/scenes/triangle/load"));
  EXPECT_EQ(admin().status()->at("scenes").size(), 1u);
  EXPECT_TRUE(metrics_say("gnomon_scene_resident{scene=\"triangle\"} 1"));
}

// A client that asks for an unloaded scene has it loaded again, and its frames are of that scene.
TEST_F(AdminActions, ClientsBringAnUnloadedSceneBack) {
  start();
  for (int round = 0; round < 20; ++round) {
    TestClient c = client();
    ASSERT_TRUE(c.join(TestClient::hello(kScene)));
    c.send_view(1, 1);
    ASSERT_FALSE(c.receive_frame(1).empty()) << "round " << round;
    c.send(protocol::Bye{});
    ASSERT_TRUE(eventually([&] { return admin().post("/scenes/triangle/unload").has_value(); }));
  }
}

TEST_F(AdminActions, WhatCannotBeLoadedSaysWhy) {
  start();
  EXPECT_EQ(refusal_of("/scenes/nothing/load"), "the configuration has no such scene");
  EXPECT_NE(refusal_of("/scenes/broken.gltf/load").find("broken.gltf"), std::string::npos);
  EXPECT_EQ(refusal_of("/scenes/dark.gltf/load"), "it has no lights: there is nothing to trace");
}

constexpr const char* kActions[] = {"/reload",
                                    "/drain",
                                    "/undrain",
                                    "/stop",
                                    "/sessions/1/kick",
                                    "/scenes/triangle/unload",
                                    "/scenes/triangle/load",
                                    "/scenes/triangle/lights/0",
                                    "/lights",
                                    "/devices/0/drain",
                                    "/devices/0/resume"};

TEST_F(AdminActions, WhoChangesSomethingOverTcpShowsTheTokenAndWhoLooksNeedsNone) {
  const std::string token = "0123456789abcdef";
  write_token(token + "\n");
  start();
  for (const char* path : kActions) {
    EXPECT_NE(refusal(over_tcp(), path).find("this needs the token of admin.token_file"), std::string::npos)
        << path;
  }
  for (const std::string& shown : {token.substr(1), token + "0", std::string("0123456789abcdeg")}) {
    EXPECT_EQ(refusal(over_tcp(shown), "/drain"), "this is not the token of admin.token_file") << shown;
  }
  EXPECT_FALSE(over_tcp().status()->at("draining"));
  EXPECT_EQ(over_tcp().status()->at("scenes").size(), 1u) << "and looking needs none";
  EXPECT_TRUE(over_tcp(token).post("/scenes/triangle/unload"));
  EXPECT_TRUE(over_tcp().status()->at("scenes").empty());
  EXPECT_EQ(count_of(Fault::admin_no_token), std::size(kActions));
  EXPECT_EQ(count_of(Fault::admin_wrong_token), 3u);
}

TEST_F(AdminActions, WithoutAConfiguredTokenTcpChangesNothingAndTheSocketDoes) {
  start();
  for (const char* path : kActions) {
    const std::string why = refusal(over_tcp("0123456789abcdef"), path);
    EXPECT_NE(why.find("admin.token_file"), std::string::npos) << path << ": " << why;
    EXPECT_NE(why.find(daemon_->admin().socket().string()), std::string::npos) << path << ": " << why;
  }
  EXPECT_EQ(over_tcp().status()->at("scenes").size(), 1u);
  EXPECT_TRUE(admin().post("/scenes/triangle/unload"));
}

// tcp_access_test has the times.
TEST_F(AdminActions, WhoGuessesIsToldToWaitAndOperatorsOfThisMachineAreNotConcerned) {
  write_token("0123456789abcdef");
  start();
  const std::string wait = "too many wrong tokens came from your address: wait";
  ASSERT_TRUE(eventually([&] { return refusal(over_tcp("guess"), "/drain") == wait; }));
  EXPECT_GT(count_of(Fault::admin_wrong_token), TokenBackoff::kFree);
  EXPECT_FALSE(admin().status()->at("draining"));
  EXPECT_TRUE(admin().post("/devices/0/resume"));
}

TEST_F(AdminActions, ATokenFileThatIsMissingShortOrReadByOthersStopsTheStart) {
  const auto complaint = [&] {
    const auto daemon = try_start();
    return daemon ? "started" : daemon.error().message;
  };
  config_.admin.token_file = folder_ / "token";
  EXPECT_NE(complaint().find("token: No such file or directory"), std::string::npos) << complaint();
  write_token("012345678901234\n");
  EXPECT_NE(complaint().find("shorter than 16"), std::string::npos) << complaint();
  write_token("0123456789abcdef\n");
  chmod(config_.admin.token_file.c_str(), 0644);
  EXPECT_NE(complaint().find("may be read by others"), std::string::npos) << complaint();
}

TEST_F(AdminActions, AReloadReadsTheTokenAgainAndAMistakeChangesNothing) {
  const std::string first = "0123456789abcdef", second = "fedcba9876543210";
  write_token(first);
  start();
  const auto works = [&](const std::string& token) {
    return over_tcp(token).post("/devices/0/resume").has_value();
  };
  write_token(second);
  EXPECT_TRUE(works(first)) << "not before the reload";
  ASSERT_TRUE(daemon_->reload(config_));
  EXPECT_FALSE(works(first));
  EXPECT_TRUE(works(second));

  write_token("too short");
  const auto refused = daemon_->reload(config_);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("admin.token_file"), std::string::npos);
  EXPECT_TRUE(works(second));
  EXPECT_FALSE(works("too short"));

  config_.admin.token_file.clear();
  ASSERT_TRUE(daemon_->reload(config_)) << "on loopback alone";
  EXPECT_FALSE(works(second));
  EXPECT_FALSE(works(""));
}

class AdminOffLoopback : public AdminActions {
 protected:
  void SetUp() override {
    AdminActions::SetUp();
    write_token(kToken);
    authority_ =
        make("authority", {.name = "authority", .hosts = {}, .use = CertificateOptions::Use::authority}, nullptr);
    make("server", {.name = "node", .hosts = {"127.0.0.1"}}, &authority_);
    config_.admin.listen = "0.0.0.0";
    config_.admin.tls = {folder_ / "server.pem", folder_ / "server-key.pem"};
  }
  Identity make(const std::string& name, CertificateOptions options, const Identity* issuer) {
    options.lasts = std::chrono::hours(1);
    const auto made = make_certificate(options, issuer);
    EXPECT_TRUE(made);
    std::ofstream(folder_ / (name + ".pem")) << made->certificate;
    std::ofstream(folder_ / (name + "-key.pem")) << made->key;
    chmod((folder_ / (name + "-key.pem")).c_str(), 0600);
    return *made;
  }
  ctl::AdminClient over_tls(const std::string& authority, const std::string& host = "127.0.0.1",
                            const std::string& name = {}) {
    return ctl::AdminClient({.address = "https://" + host + ":" + std::to_string(daemon_->admin().port()),
                             .token = kToken,
                             .authority = folder_ / authority,
                             .name = name});
  }
  static constexpr const char* kToken = "0123456789abcdef";
  Identity authority_;
};

TEST_F(AdminOffLoopback, TlsIsSpokenAndClientsCheckWithWhom) {
  start();
  EXPECT_TRUE(over_tls("authority.pem").status());
  EXPECT_TRUE(over_tls("authority.pem").post("/devices/0/resume"));
  EXPECT_FALSE(over_tls("authority.pem", "127.0.0.2").status()) << "not the certificate's host";
  EXPECT_TRUE(over_tls("authority.pem", "127.0.0.2", "127.0.0.1").status()) << "whose name was said";
  EXPECT_FALSE(over_tls("authority.pem", "127.0.0.1", "gnomon.example").status());
  make("another", {.name = "another", .hosts = {}, .use = CertificateOptions::Use::authority}, nullptr);
  EXPECT_FALSE(over_tls("another.pem").status());
  EXPECT_FALSE(over_tcp().status()) << "in clear";
}

TEST_F(AdminOffLoopback, AReloadReadsTheCertificateAgain) {
  start();
  authority_ = make("next", {.name = "next", .hosts = {}, .use = CertificateOptions::Use::authority}, nullptr);
  make("server", {.name = "node", .hosts = {"127.0.0.1"}}, &authority_);
  EXPECT_FALSE(over_tls("next.pem").status()) << "not before";
  ASSERT_TRUE(daemon_->reload(config_));
  EXPECT_TRUE(over_tls("next.pem").status());
}

// Another address in the file needs a restart; until then the rules of the running address apply.
TEST_F(AdminOffLoopback, WhereStrangersReachItTheTokenStays) {
  start();
  config_.admin.listen = "127.0.0.1";
  config_.admin.token_file.clear();
  const auto refused = daemon_->reload(config_);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("admin.listen"), std::string::npos);
}

TEST_F(AdminActions, ATokenNeverCrossesInClear) {
  const auto status = ctl::AdminClient({.address = "http://192.0.2.1:7601", .token = "0123456789abcdef"}).status();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("in clear"), std::string::npos) << status.error().message;
}

TEST_F(AdminActions, AStopIsSeenAtOnce) {
  std::atomic<int> asked = 0;
  on_stop_ = [&] { ++asked; };
  start();
  ASSERT_TRUE(admin().post("/stop"));
  EXPECT_EQ(asked, 1);
  EXPECT_TRUE(admin().status()->at("stopping"));
  EXPECT_NE(ctl::status_text(*admin().status()).find("stopping"), std::string::npos);
  EXPECT_NE(refusal_of("/undrain").find("cannot be taken back"), std::string::npos);
}

TEST_F(AdminActions, ADrainAdmitsNobodyServesOnAndIsTakenBack) {
  on_stop_ = [] { FAIL() << "nobody asked for that"; };
  start();
  TestClient stays = client();
  ASSERT_TRUE(stays.join(TestClient::hello(kScene)));
  ASSERT_TRUE(admin().post("/drain"));
  EXPECT_TRUE(admin().status()->at("draining"));
  EXPECT_FALSE(admin().status()->at("ready"));
  EXPECT_NE(ctl::status_text(*admin().status()).find("draining"), std::string::npos);
  TestClient late = client();
  late.send(TestClient::hello(kScene));
  const auto refused = late.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, protocol::RefusalCode::draining);
  stays.send_view(1, 1);
  EXPECT_FALSE(stays.receive_frame(1).empty()) << "who is here is served on";
  ASSERT_TRUE(admin().post("/undrain"));
  EXPECT_TRUE(admin().status()->at("ready"));
  EXPECT_TRUE(client().join(TestClient::hello(kScene)));
  stays.send_view(2, 1);
  EXPECT_FALSE(stays.receive_frame(2).empty());
}

TEST_F(AdminActions, TheOnlyDeviceStaysInService) {
  start();
  EXPECT_NE(refusal_of("/devices/0/drain").find("no other device takes sessions"), std::string::npos);
  EXPECT_FALSE(admin().status()->at("devices")[0].at("drained"));
  EXPECT_TRUE(client().join(TestClient::hello(kScene)));
}

TEST_F(AdminActions, TopShowsRatesBetweenTwoLooks) {
  const auto status = [](int frames) {
    return nlohmann::json{{"sessions", {{{"id", "7"}, {"tenant", "lab"}, {"frames", frames}}}},
                          {"tenants", {{{"name", "lab"}, {"weight", 3}}}}};
  };
  const std::string text = ctl::top_text(status(100), status(160), 2.0);
  EXPECT_NE(text.find("vbps 30.0"), std::string::npos) << text;
}

TEST(AdminClient, AnAddressIsASocketOrAUrl) {
  using Kind = ctl::AdminAddress::Kind;
  const auto is = [](const std::string& text, Kind kind, const std::string& host, const std::string& port) {
    const auto read = ctl::parse_admin_address(text);
    ASSERT_TRUE(read) << text;
    EXPECT_EQ(read->kind, kind) << text;
    EXPECT_EQ(read->host, host) << text;
    EXPECT_EQ(read->port, port) << text;
    EXPECT_EQ(read->text(), text);
  };
  is("unix:/run/gnomon/admin.sock", Kind::unix_socket, "/run/gnomon/admin.sock", "");
  is("http://127.0.0.1:7601", Kind::http, "127.0.0.1", "7601");
  is("https://node7:443", Kind::https, "node7", "443");
  is("http://[::1]:7601", Kind::http, "::1", "7601");
  for (const char* wrong :
       {"", "unix:", "127.0.0.1:7601", "http://", "http://:7601", "http://node7",
        "http://node7:", "http://node7:7601/status", "http://[::1]", "http://[]:1", "ftp://node7:21"}) {
    EXPECT_FALSE(ctl::parse_admin_address(wrong)) << wrong;
  }
}

TEST(AdminClient, SaysThatNobodyAnswers) {
  const auto status = ctl::AdminClient({.address = "http://127.0.0.1:1"}).status();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("http://127.0.0.1:1 does not answer"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::daemon
