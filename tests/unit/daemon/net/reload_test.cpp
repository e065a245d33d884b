// What a reload of the configuration changes, keeps and says.
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

using protocol::RefusalCode;
using namespace std::chrono_literals;

TEST_F(Served, AReloadChangesTermsAndLimitsAndDropsNobody) {
  config_.tenants = {{.name = kDefaultTenant}};
  start();
  TestClient stays = client(), late = client();
  ASSERT_TRUE(stays.join(TestClient::hello(kScene)));
  Config next = config_;
  next.scheduler.policy = "priority";
  next.tenants[0].max_sessions = 1;
  ASSERT_TRUE(daemon_->reload(next));
  late.send(TestClient::hello(kScene));
  const auto refused = late.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, RefusalCode::too_many_sessions);
  stays.send_view(1, 2);
  EXPECT_TRUE(is_frame_of(stays, stays.receive_frame(1), 2)) << "under the new policy";

  EXPECT_FALSE(daemon_->reload(Error{"not a configuration"}));
  EXPECT_TRUE(metrics_say("gnomon_config_reloads_total{result=\"done\"} 1"));
  EXPECT_TRUE(metrics_say("gnomon_config_reloads_total{result=\"failed\"} 1"));
  EXPECT_TRUE(metrics_say("gnomon_tenant_refusals_total{limit=\"sessions\",tenant=\"default\"} 1"));
}

TEST_F(Served, AReloadBringsChangesAndTakesScenes) {
  start();
  const auto refusal_of = [&](const std::string& scene) {
    TestClient c = client();
    return c.join(TestClient::hello(scene)) ? "" : "refused";
  };
  write_scene(folder_ / "bunny.gltf", true, R"("name": "ears", )");
  write_scene(folder_ / "files" / "late.gltf", true);
  EXPECT_EQ(refusal_of("bunny"), std::string("refused"));
  Config next = config_;
  next.scenes.list.push_back({"bunny", folder_ / "bunny.gltf", ""});
  next.scenes.allow_files.push_back(folder_ / "more");
  std::filesystem::create_directory(folder_ / "more");
  write_scene(folder_ / "more" / "again.gltf", true);
  const auto done = daemon_->reload(next);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_TRUE(eventually([&] { return metrics_say("gnomon_scene_resident{scene=\"bunny\"} 1"); })) << "at once";
  for (const char* scene : {"bunny", "late.gltf", "again.gltf"})
    EXPECT_EQ(refusal_of(scene), std::string()) << scene;

  // A scene that is in use stays as it was, and another reload takes it once it is not.
  TestClient stays = client();
  ASSERT_TRUE(stays.join(TestClient::hello("bunny")));
  next.scenes.list[1].moving = {{.node = "ears", .spin = {0, 1, 0}, .shift = {}}};
  next.scenes.list.erase(next.scenes.list.begin());
  const auto in_part = daemon_->reload(next);
  ASSERT_FALSE(in_part);
  EXPECT_NE(in_part.error().message.find("scene bunny is in use and stays as it was"), std::string::npos)
      << in_part.error().message;
  stays.send_view(1, 2);
  EXPECT_TRUE(is_frame_of(stays, stays.receive_frame(1), 2));
  EXPECT_EQ(refusal_of(kScene), std::string("refused")) << "the one that nobody used is gone";
  stays.send(protocol::Bye{});
  ASSERT_TRUE(eventually([&] { return metrics_say("gnomon_sessions{tenant=\"default\"} 0"); }));
  EXPECT_TRUE(eventually([&] { return daemon_->reload(next).has_value(); }));
}

TEST_F(Served, AReloadKeepsASceneWhoseChangeCannotBeRead) {
  start();
  const auto is_served = [&] { return client().join(TestClient::hello(kScene)); };
  const auto refusal_of = [&](Config next) {
    const auto done = daemon_->reload(next);
    EXPECT_TRUE(is_served());
    return done ? std::string("none") : done.error().message;
  };
  Config next = config_;
  next.scenes.list[0].moving = {{.node = "leaf", .spin = {0, 1, 0}, .shift = {}}};
  next.tenants[0].weight = 3;
  next.values["tenants.default.weight"] = "3";
  EXPECT_NE(
      refusal_of(next).find("no node is named 'leaf'; it stays as it was\ntenants.default.weight: (default) -> 3"),
      std::string::npos);
  next.scenes.list[0] = config_.scenes.list[0];
  next.scenes.list[0].file = folder_ / "files" / "broken.gltf";
  EXPECT_NE(refusal_of(next).find("scene triangle: "), std::string::npos);
  next.scenes.list[0].file = folder_ / "files" / "dark.gltf";
  EXPECT_NE(refusal_of(next).find("no lights"), std::string::npos);
  next.scenes.list[0].file = folder_ / "files" / "absent.gltf";  // which the check of the configuration says
  refusal_of(next);
}

TEST_F(Served, AReloadTakesAFileThatWasReplaced) {
  start();
  const auto hash = [&] {
    TestClient asks = client();
    EXPECT_TRUE(asks.join(TestClient::hello(kScene)));
    const auto found = asks.welcome().scene.content_hash;
    asks.send(protocol::Bye{});
    return found;
  };
  const auto before = hash();
  write_scene(folder_ / "triangle.gltf", true, R"("translation": [0, 0, 1], )");
  std::filesystem::last_write_time(folder_ / "triangle.gltf",
                                   std::filesystem::last_write_time(folder_ / "triangle.gltf") + 2s);
  // Until the session that asked has left the device too, its scene is in use and stays.
  ASSERT_TRUE(eventually([&] { return daemon_->reload(config_).has_value(); }));
  EXPECT_TRUE(eventually([&] { return hash() != before; }));
}

TEST_F(Served, AReloadChangesHowTheLogIsWritten) {
  start();
  Config next = config_;
  next.log.level = log::Level::info;
  next.log.format = log::Format::json;
  testing::internal::CaptureStderr();
  EXPECT_TRUE(daemon_->reload(next) && daemon_->reload(config_));
  const std::string text = testing::internal::GetCapturedStderr();
  log::configure(log::Level::warning, log::Format::key_value);
  EXPECT_NE(text.find("\"event\":\"configuration reloaded\""), std::string::npos) << text;
  EXPECT_NE(text.find(" configuration reloaded policy=fair"), std::string::npos) << text;
}

TEST_F(Served, AReloadNamesTheKeysThatTakeARestart) {
  start();
  Config next = config_;
  next.server.silence_timeout *= 2;
  next.render.tracer = "bvh";
  next.scheduler.policy = "priority";
  const auto in_part = daemon_->reload(next);
  ASSERT_FALSE(in_part);
  for (const char* key : {"server.silence_timeout_ms: changed, which takes a restart",
                          "render.tracer: changed, which takes a restart"}) {
    EXPECT_NE(in_part.error().message.find(key), std::string::npos) << in_part.error().message;
  }
  EXPECT_EQ(in_part.error().message.find("scheduler"), std::string::npos);
  EXPECT_TRUE(metrics_say("gnomon_config_reloads_total{result=\"failed\"} 1"));
}

TEST_F(Served, AReloadBringsTenantsAndClosesThoseThatAreGone) {
  config_.tenants = {{.name = kDefaultTenant}, {.name = "leaving"}};
  start();
  protocol::Hello leaving = TestClient::hello(kScene), arriving = leaving;
  leaving.tenant = "leaving";
  arriving.tenant = "arriving";
  TestClient stays = client(), goes = client(), early = client();
  ASSERT_TRUE(stays.join(TestClient::hello(kScene)));
  ASSERT_TRUE(goes.join(leaving));
  early.send(arriving);
  EXPECT_EQ(early.receive_a<protocol::Refused>()->code, RefusalCode::unknown_tenant);

  Config next = config_;
  next.tenants = {{.name = "arriving", .weight = 3}, {.name = kDefaultTenant}};  // another order, too
  ASSERT_TRUE(daemon_->reload(next));
  EXPECT_EQ(goes.receive_a<protocol::Bye>()->reason, "the tenant is no longer served");
  TestClient comes = client(), late = client();
  ASSERT_TRUE(comes.join(arriving));
  late.send(leaving);
  EXPECT_EQ(late.receive_a<protocol::Refused>()->code, RefusalCode::unknown_tenant);
  stays.send_view(1, 2);
  comes.send_view(1, 3);
  EXPECT_TRUE(is_frame_of(stays, stays.receive_frame(1), 2));
  EXPECT_TRUE(is_frame_of(comes, comes.receive_frame(1), 3));
  EXPECT_TRUE(metrics_say("gnomon_sessions{tenant=\"arriving\"} 1"));
  EXPECT_TRUE(metrics_say("gnomon_sessions{tenant=\"default\"} 1"));
  EXPECT_TRUE(metrics_say("gnomon_sessions{tenant=\"leaving\"} 0"));

  ASSERT_TRUE(daemon_->reload(config_));  // the tenant is named again and keeps its id
  TestClient again = client();
  ASSERT_TRUE(again.join(leaving));
  EXPECT_TRUE(metrics_say("gnomon_sessions{tenant=\"leaving\"} 1"));
}

}  // namespace
}  // namespace gnomon::daemon
