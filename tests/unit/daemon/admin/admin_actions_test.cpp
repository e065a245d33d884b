// Operators' actions on a running daemon, through the library behind gnomonctl.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "daemon/ctl/admin_client.h"
#include "daemon/ctl/views.h"
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

class AdminActions : public Served {
 protected:
  ctl::AdminClient admin() { return ctl::AdminClient("http://127.0.0.1:" + std::to_string(daemon_->admin_port())); }
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
  std::string refusal_of(const std::string& path) {
    const auto answer = admin().post(path);
    return answer ? "done: " + *answer : answer.error().message;
  }
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

TEST_F(AdminActions, WhoChangesSomethingShowsTheTokenAndWhoLooksNeedsNone) {
  const std::string token = "0123456789abcdef";
  write_token(token + "\n");
  start();
  const std::string url = "http://127.0.0.1:" + std::to_string(daemon_->admin_port());
  for (const char* path :
       {"/reload", "/drain", "/sessions/1/kick", "/scenes/triangle/unload", "/scenes/triangle/load",
        "/scenes/triangle/lights/0", "/devices/0/drain", "/devices/0/resume"}) {
    for (const std::string& shown :
         {std::string(), token.substr(1), token + "0", std::string("0123456789abcdeg")}) {
      const auto answer = ctl::AdminClient(url, shown).post(path);
      ASSERT_FALSE(answer) << path;
      EXPECT_EQ(answer.error().message, "this needs the token of admin.token_file") << path;
    }
  }
  EXPECT_FALSE(admin().status()->at("draining"));
  EXPECT_EQ(admin().status()->at("scenes").size(), 1u) << "and looking needs none";
  EXPECT_TRUE(ctl::AdminClient(url, token).post("/scenes/triangle/unload"));
  EXPECT_TRUE(admin().status()->at("scenes").empty());
}

TEST_F(AdminActions, ATokenFileThatIsMissingShortOrReadByOthersStopsTheStart) {
  const auto complaint = [&] {
    const auto daemon = try_start();
    return daemon ? "started" : daemon.error().message;
  };
  config_.admin.token_file = folder_ / "token";
  EXPECT_NE(complaint().find("token cannot be read"), std::string::npos) << complaint();
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
  const std::string url = "http://127.0.0.1:" + std::to_string(daemon_->admin_port());
  const auto works = [&](const std::string& token) {
    return ctl::AdminClient(url, token).post("/devices/0/resume").has_value();
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
  EXPECT_TRUE(works(""));
}

// Another address in the file needs a restart; until then the rules of the running address apply.
TEST_F(AdminActions, WhereStrangersReachItTheTokenStays) {
  write_token("0123456789abcdef");
  config_.admin.listen = "0.0.0.0";
  start();
  config_.admin = {.listen = "127.0.0.1"};
  const auto refused = daemon_->reload(config_);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().message.find("admin.listen"), std::string::npos);
  EXPECT_EQ(refusal_of("/drain"), "this needs the token of admin.token_file");
}

TEST_F(AdminActions, DrainIsSeenAtOnce) {
  std::atomic<int> asked = 0;
  on_drain_ = [&] { ++asked; };
  start();
  ASSERT_TRUE(admin().post("/drain"));
  EXPECT_EQ(asked, 1);
  EXPECT_TRUE(admin().status()->at("draining"));
  EXPECT_NE(ctl::status_text(*admin().status()).find("draining"), std::string::npos);
}

TEST_F(AdminActions, TopShowsRatesBetweenTwoLooks) {
  const auto status = [](int frames) {
    return nlohmann::json{{"sessions", {{{"id", "7"}, {"tenant", "lab"}, {"frames", frames}}}},
                          {"tenants", {{{"name", "lab"}, {"weight", 3}}}}};
  };
  const std::string text = ctl::top_text(status(100), status(160), 2.0);
  EXPECT_NE(text.find("vbps 30.0"), std::string::npos) << text;
}

TEST(AdminClient, SaysThatNobodyAnswers) {
  const auto status = ctl::AdminClient("http://127.0.0.1:1").status();
  ASSERT_FALSE(status);
  EXPECT_NE(status.error().message.find("http://127.0.0.1:1 does not answer"), std::string::npos);
}

}  // namespace
}  // namespace gnomon::daemon
