// Well-behaved clients: joining, being refused, getting frames, leaving.
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

using protocol::RefusalCode;
using namespace std::chrono_literals;

TEST_F(Served, WelcomesAndAnswersWithTheMasksOfTheCameraAskedFor) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  EXPECT_EQ(c.welcome().width, 32);
  EXPECT_EQ(c.welcome().height, 24);
  EXPECT_EQ(c.welcome().data_port, daemon_->server().data_ports()[0]);
  EXPECT_EQ(c.welcome().scene.name, kScene);
  EXPECT_EQ(c.welcome().scene.triangles, 1u);
  EXPECT_EQ(c.welcome().scene.lights.size(), 1u);
  for (uint32_t frame = 1; frame <= 20; ++frame) {
    const float x = static_cast<float>(frame) / 4;
    c.send_view(frame, x);
    EXPECT_TRUE(is_frame_of(c, c.receive_frame(frame), x)) << frame;
  }
  EXPECT_TRUE(eventually([&] {
    return metrics_say("gnomon_visibility_buffers_total{tenant=\"default\"} 20") &&
           metrics_say("gnomon_scene_visibility_buffers_total{scene=\"triangle\"} 20");
  })) << daemon_->metrics().text();
  EXPECT_TRUE(metrics_say("gnomon_sessions{tenant=\"default\"} 1"));
}

TEST_F(Served, ServesManyClientsOverSeveralNetThreads) {
  config_.server.net_threads = 3;
  start();
  EXPECT_EQ(daemon_->server().data_ports().size(), 3u);
  std::vector<std::unique_ptr<TestClient>> clients;
  for (int i = 0; i < 12; ++i) {
    clients.push_back(std::make_unique<TestClient>(daemon_->control_port()));
    ASSERT_TRUE(clients.back()->join(TestClient::hello(kScene))) << i;
  }
  for (uint32_t frame = 1; frame <= 5; ++frame) {
    for (size_t i = 0; i < clients.size(); ++i) clients[i]->send_view(frame, static_cast<float>(i));
    for (size_t i = 0; i < clients.size(); ++i) {
      EXPECT_TRUE(is_frame_of(*clients[i], clients[i]->receive_frame(frame), static_cast<float>(i))) << i;
    }
  }
}

TEST_F(Served, FollowsAClientWhoseAddressChanges) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  c.send_view(1, 1);
  EXPECT_TRUE(is_frame_of(c, c.receive_frame(1), 1));
  c.change_data_port();
  c.send_view(2, 2);  // its frame goes to the address before
  EXPECT_TRUE(c.validate_address());
  c.send_view(3, 3);
  EXPECT_TRUE(is_frame_of(c, c.receive_frame(3), 3));
}

TEST_F(Served, ServesOverTheControlConnectionAndBackAgain) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  for (uint32_t frame = 1; frame <= 5; ++frame) {
    c.send_view_by_control(frame, static_cast<float>(frame));
    EXPECT_TRUE(is_frame_of(c, c.receive_frame_by_control(frame), static_cast<float>(frame))) << frame;
  }
  c.send_view(6, 6);
  EXPECT_TRUE(is_frame_of(c, c.receive_frame(6), 6)) << "datagrams pass again";
  c.send_view_by_control(7, 7);
  EXPECT_TRUE(is_frame_of(c, c.receive_frame_by_control(7), 7));
}

TEST_F(Served, AnswersPingsWithoutChangingWhereFramesGo) {
  start();
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  const auto pong = c.ping();
  ASSERT_TRUE(pong);
  EXPECT_EQ(pong->kind, protocol::DatagramKind::pong);
  c.send_view_by_control(1, 1);
  EXPECT_TRUE(is_frame_of(c, c.receive_frame_by_control(1), 1));
  EXPECT_TRUE(c.ping());
  c.send_view_by_control(2, 2);
  EXPECT_TRUE(is_frame_of(c, c.receive_frame_by_control(2), 2));
}

TEST_F(Served, EveryCodecBringsEveryFrame) {
  using protocol::CodecId;
  config_.encode.threads = 3;
  start();
  const TileGrid grid{160, 120, kLights};
  for (const CodecId codec : protocol::kCodecs) {
    TestClient client = this->client();
    auto hello = TestClient::hello(kScene, 160, 120);
    hello.features = protocol::kFeatureReferences;
    hello.codecs = {codec};
    ASSERT_TRUE(client.join(hello));
    EXPECT_EQ(client.welcome().codec, codec);
    ASSERT_TRUE(client.welcome().features & protocol::kFeatureReferences);
    // The same picture again and again, so that it is worth referring to.
    for (uint32_t frame = 1; frame <= 4; ++frame) {
      client.send_view(frame, 0.5f);
      const std::vector<uint64_t> words = client.receive_frame(frame);
      ASSERT_EQ(words.size(), grid.word_count()) << "frame " << frame;
      gpu::CameraView camera;
      camera.position.x = 0.5f;
      for (size_t word = 0; word < words.size(); ++word) ASSERT_EQ(words[word], fake_word(camera, word));
      EXPECT_EQ(client.codec(), codec);
      EXPECT_EQ(client.referred(), codec == CodecId::tiles_context && frame > 1);
    }
  }
}

TEST_F(Served, AClientThatKeepsNoFramesGetsNoneThatRefer) {
  start();
  TestClient client = this->client();
  auto hello = TestClient::hello(kScene);
  hello.codecs = {protocol::CodecId::tiles_context};
  ASSERT_TRUE(client.join(hello));
  for (uint32_t frame = 1; frame <= 3; ++frame) {
    client.send_view(frame, 0.01f);
    EXPECT_FALSE(client.receive_frame(frame).empty());
    EXPECT_EQ(client.codec(), protocol::CodecId::tiles_context);
    EXPECT_FALSE(client.referred());
  }
}

TEST_F(Served, AConfiguredContextCodecIsForClientsThatDecodeIt) {
  config_.encode.codec = protocol::CodecId::tiles_context;
  start();
  TestClient plain = client(), able = client();
  ASSERT_TRUE(plain.join(TestClient::hello(kScene)));
  EXPECT_EQ(plain.welcome().codec, protocol::CodecId::tiles_lz4);
  auto hello = TestClient::hello(kScene);
  hello.features = protocol::kFeatureReferences;
  ASSERT_TRUE(able.join(hello));
  EXPECT_EQ(able.welcome().codec, protocol::CodecId::tiles_context);
}

TEST_F(Served, ServesFilesBelowTheAllowedFoldersAndNoOthers) {
  start();
  for (const std::string& name : {std::string("another.gltf"), (folder_ / "files" / "another.gltf").string()}) {
    TestClient c = client();
    ASSERT_TRUE(c.join(TestClient::hello(name))) << name;
    EXPECT_EQ(c.welcome().scene.name, "another.gltf");
    c.send_view(1, 3);
    EXPECT_TRUE(is_frame_of(c, c.receive_frame(1), 3));
  }
  for (const std::string& name : {std::string("../triangle.gltf"), (folder_ / "triangle.gltf").string(),
                                  (folder_ / "files/../triangle.gltf").string(), std::string("/etc/passwd")}) {
    TestClient c = client();
    c.send(TestClient::hello(name));
    const auto refused = c.receive_a<protocol::Refused>();
    ASSERT_TRUE(refused) << name;
    EXPECT_EQ(refused->code, RefusalCode::unknown_scene) << name;
  }
}

TEST_F(Served, LimitsSessionsAndGivesSeatsBack) {
  config_.tenants = {{.name = kDefaultTenant}, {.name = "small", .max_sessions = 1}};
  config_.server.max_sessions = 3;
  start();
  protocol::Hello small = TestClient::hello(kScene);
  small.tenant = "small";
  TestClient first = client();
  ASSERT_TRUE(first.join(small));
  TestClient second = client();
  second.send(small);
  const auto refused = second.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, RefusalCode::too_many_sessions);
  TestClient third = client(), fourth = client(), fifth = client();
  EXPECT_TRUE(third.join(TestClient::hello(kScene)));
  EXPECT_TRUE(fourth.join(TestClient::hello(kScene)));
  fifth.send(TestClient::hello(kScene));
  const auto full = fifth.receive_a<protocol::Refused>();
  ASSERT_TRUE(full);
  EXPECT_EQ(full->code, RefusalCode::too_many_sessions);

  first.send(protocol::Bye{"done"});
  ASSERT_TRUE(eventually([&] { return metrics_say("gnomon_sessions{tenant=\"small\"} 0"); }));
  EXPECT_FALSE(first.receive_a<protocol::Bye>()) << "nothing is said after a Bye";
  TestClient sixth = client();
  EXPECT_TRUE(sixth.join(small));
}

TEST_F(Served, ReapsSilentAndVanishedSessions) {
  config_.server.silence_timeout = 300ms;
  start();
  TestClient silent = client(), vanished = client();
  ASSERT_TRUE(silent.join(TestClient::hello(kScene)));
  ASSERT_TRUE(vanished.join(TestClient::hello(kScene)));
  vanished.send_view(1, 1);
  vanished.vanish();
  const auto bye = silent.receive_a<protocol::Bye>();
  ASSERT_TRUE(bye);
  EXPECT_EQ(bye->reason, "silent");
  EXPECT_TRUE(eventually([&] { return metrics_say("gnomon_sessions{tenant=\"default\"} 0"); }));
}

TEST_F(Served, DrainTellsTheClientsServesThemAndRefusesNewOnes) {
  config_.server.drain_timeout = 30s;
  start();
  TestClient staying = client();
  ASSERT_TRUE(staying.join(TestClient::hello(kScene)));
  std::thread draining([&] { daemon_->drain(); });
  const auto told = staying.receive_a<protocol::Draining>();
  ASSERT_TRUE(told);
  EXPECT_EQ(told->deadline_ms, 30'000u);
  TestClient late = client();
  late.send(TestClient::hello(kScene));
  const auto refused = late.receive_a<protocol::Refused>();
  EXPECT_TRUE(refused && refused->code == RefusalCode::draining);
  staying.send_view(1, 1);
  EXPECT_TRUE(is_frame_of(staying, staying.receive_frame(1), 1)) << "served until it leaves";
  staying.send(protocol::Bye{"moving on"});
  draining.join();
}

TEST_F(Served, DrainEndsAtItsDeadlineWithByeToThoseWhoStay) {
  start();  // deadline: now
  TestClient c = client();
  ASSERT_TRUE(c.join(TestClient::hello(kScene)));
  daemon_->drain();
  EXPECT_TRUE(c.receive_a<protocol::Bye>());
  EXPECT_FALSE(c.receive());
}

// The watchdog asks for it until the process ends.
TEST_F(Served, TheSummaryMayBeAskedForAfterTheEnd) {
  start();
  daemon_->drain();
  EXPECT_EQ(daemon_->summary(), "serving 1 scenes to 0 sessions");
}

TEST_F(Served, PortsInUseAreAnErrorThatNamesTheKey) {
  start();
  const auto refused = [&](const std::function<void(Config&)>& change) {
    Daemon::Options options;
    options.config = config_;
    change(options.config);
    options.make_renderers = {[]() -> Result<std::unique_ptr<gpu::Renderer>> { return Error{"never reached"}; }};
    const auto second = Daemon::start(std::move(options));
    return second ? std::string("started") : second.error().message;
  };
  EXPECT_NE(
      refused([&](Config& c) { c.server.control_port = daemon_->control_port(); }).find("server.control_port"),
      std::string::npos);
  EXPECT_NE(
      refused([&](Config& c) { c.server.data_port = daemon_->server().data_ports()[0]; }).find("server.data_port"),
      std::string::npos);
  EXPECT_NE(refused([&](Config& c) {
              c.admin.port = daemon_->admin().port();
              c.admin.socket.clear();
            }).find("admin.port"),
            std::string::npos);
  EXPECT_NE(refused([&](Config& c) { c.server.listen = "203.0.113.1"; }).find("server."), std::string::npos);
}

TEST_F(Served, AConfiguredSceneThatDoesNotLoadStopsTheStart) {
  config_.scenes.list.push_back({"bad", folder_ / "files/broken.gltf", "gnomond.yaml:9: scenes.list"});
  Daemon::Options options;
  options.config = config_;
  options.make_renderers = {[]() -> Result<std::unique_ptr<gpu::Renderer>> {
    return std::unique_ptr<gpu::Renderer>(std::make_unique<FakeRenderer>(1));
  }};
  const auto daemon = Daemon::start(std::move(options));
  ASSERT_FALSE(daemon);
  EXPECT_NE(daemon.error().message.find("gnomond.yaml:9: scenes.list: scene bad"), std::string::npos)
      << daemon.error().message;
}

}  // namespace
}  // namespace gnomon::daemon
