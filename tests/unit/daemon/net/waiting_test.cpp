// Connections that wait for a session, beside others that do not deserve one.
#include <future>

#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

// `another.gltf` is read, but does not come to the device until the test lets it.
class Waiting : public Served {
 protected:
  void SetUp() override {
    Served::SetUp();
    config_.server.handshake_timeout = 30s;  // so that it ends no connection
    make_renderers_ = {[this]() -> Result<std::unique_ptr<gpu::Renderer>> {
      auto made = std::make_unique<SelfRunningFakeRenderer>(3, kLights, 0ms);
      renderer_ = made.get();
      return std::unique_ptr<gpu::Renderer>(std::move(made));
    }};
  }

  void start_with_a_scene_that_does_not_come() {
    start();
    renderer_->holds_scenes = true;
  }

  bool places_taken(int count) {
    return eventually(
        [&] { return daemon_->summary().find(" to " + std::to_string(count) + " sessions") != std::string::npos; });
  }

  SelfRunningFakeRenderer* renderer_ = nullptr;
};

TEST_F(Waiting, StrangersDoNotPushOutWhoWasLetIn) {
  config_.server.max_half_open = 8;
  start_with_a_scene_that_does_not_come();
  TestClient honest = client();
  honest.send(TestClient::hello("another.gltf"));
  ASSERT_TRUE(places_taken(1));
  asio::io_context io;
  std::vector<asio::ip::tcp::socket> strangers;
  for (int i = 0; i < 100; ++i) {
    const std::string from = "127.0.0." + std::to_string(2 + i % 20);
    strangers.emplace_back(io, asio::ip::tcp::endpoint(asio::ip::make_address(from), 0))
        .connect({asio::ip::address_v4::loopback(), daemon_->control_port()});
  }
  EXPECT_TRUE(eventually([&] { return count_of(Fault::half_open_replaced) == 92; }));
  renderer_->holds_scenes = false;
  EXPECT_TRUE(honest.receive_a<protocol::Welcome>());
}

TEST_F(Waiting, APlaceIsFreeAsSoonAsItsClientHasGone) {
  config_.server.max_sessions = 4;
  config_.tenants = {{.name = kDefaultTenant}, {.name = "greedy", .max_sessions = 0}};
  start_with_a_scene_that_does_not_come();
  auto hello = TestClient::hello("another.gltf");
  hello.tenant = "greedy";
  std::vector<std::unique_ptr<TestClient>> gone;
  for (int i = 0; i < 4; ++i) {
    gone.push_back(std::make_unique<TestClient>(daemon_->control_port()));
    gone.back()->send(hello);
  }
  ASSERT_TRUE(places_taken(4));
  for (auto& each : gone) each->vanish();
  EXPECT_TRUE(places_taken(0)) << "while the scene that they asked for has not come yet";
  TestClient honest = client();
  EXPECT_TRUE(honest.join(TestClient::hello(kScene)));
}

TEST_F(Waiting, ASecondMessageEndsTheWaitAndFreesThePlace) {
  start_with_a_scene_that_does_not_come();
  TestClient hasty = client();
  hasty.send(TestClient::hello("another.gltf"));
  ASSERT_TRUE(places_taken(1));
  hasty.send(TestClient::hello("another.gltf"));
  EXPECT_TRUE(hasty.receive_a<protocol::Refused>());
  EXPECT_TRUE(places_taken(0));
}

// Hello with the feature waiting.
protocol::Hello patient_hello(const std::string& scene) {
  auto hello = TestClient::hello(scene);
  hello.features |= protocol::kFeatureWaiting;
  return hello;
}

TEST_F(Waiting, AClientHearsWithinASecondWhatItWaitsFor) {
  start_with_a_scene_that_does_not_come();
  TestClient c = client();
  const TimePoint asked = Clock::now();
  c.send(patient_hello("another.gltf"));
  for (int i = 0; i < 2; ++i) {
    const auto first = c.receive();
    ASSERT_TRUE(first && std::holds_alternative<protocol::Waiting>(*first));
    EXPECT_EQ(std::get<protocol::Waiting>(*first).text, "the scene is being prepared on the devices");
    EXPECT_EQ(std::get<protocol::Waiting>(*first).percent, protocol::Waiting::kUnknown);
    EXPECT_LT(Clock::now() - asked, 1s + i * 2s);
  }
  renderer_->holds_scenes = false;
  EXPECT_TRUE(c.receive_a<protocol::Welcome>());
}

TEST_F(Waiting, AClientThatKnowsNoWaitingHearsTheAnswerAlone) {
  start_with_a_scene_that_does_not_come();
  TestClient c = client();
  c.send(TestClient::hello("another.gltf"));
  ASSERT_TRUE(places_taken(1));
  std::this_thread::sleep_for(800ms);
  renderer_->holds_scenes = false;
  const auto first = c.receive();
  EXPECT_TRUE(first && std::holds_alternative<protocol::Welcome>(*first));
}

TEST_F(Waiting, AFarewellBeforeTheAnswerIsNoOffence) {
  start_with_a_scene_that_does_not_come();
  TestClient c = client();
  c.send(patient_hello("another.gltf"));
  ASSERT_TRUE(places_taken(1));
  c.send(protocol::Bye{"gave up"});
  EXPECT_TRUE(places_taken(0));
  EXPECT_TRUE(eventually([&] { return count_of(Fault::handshake_abandoned) == 1; }));
  TestClient at_once = client();
  at_once.send(protocol::Bye{"never mind"});
  EXPECT_TRUE(eventually([&] { return count_of(Fault::handshake_abandoned) == 2; }));
  EXPECT_FALSE(at_once.receive_a<protocol::Refused>());
  EXPECT_EQ(count_of(Fault::refused_malformed), 0u);
}

TEST_F(Waiting, WhoComesWhileTheDaemonStartsHearsThat) {
  asio::io_context io;
  {
    asio::ip::tcp::acceptor any(io, {asio::ip::address_v4::loopback(), 0});
    config_.server.control_port = any.local_endpoint().port();
  }
  std::promise<void> may_open;
  make_renderers_ = {[&]() -> Result<std::unique_ptr<gpu::Renderer>> {
    may_open.get_future().wait();
    return std::unique_ptr<gpu::Renderer>(std::make_unique<SelfRunningFakeRenderer>(3, kLights, 0ms));
  }};
  auto starting = std::async(std::launch::async, [&] { start(); });
  ASSERT_TRUE(eventually([&] {
    asio::error_code refused;
    asio::ip::tcp::socket(io).connect({asio::ip::address_v4::loopback(), config_.server.control_port}, refused);
    return !refused;
  }));
  TestClient early(config_.server.control_port);
  early.send(patient_hello(kScene));
  const auto first = early.receive();
  ASSERT_TRUE(first && std::holds_alternative<protocol::Waiting>(*first));
  EXPECT_EQ(std::get<protocol::Waiting>(*first).text, "the server is starting");
  may_open.set_value();
  EXPECT_TRUE(early.receive_a<protocol::Welcome>());
  starting.get();
}

TEST_F(Waiting, ATenantFindsItsReserveWhateverTheOthersTake) {
  config_.server.max_sessions = 8;
  config_.tenants = {{.name = kDefaultTenant}, {.name = "greedy"}};
  start();
  auto hello = TestClient::hello(kScene);
  hello.tenant = "greedy";
  std::vector<std::unique_ptr<TestClient>> greedy;
  for (int i = 0; i < 8; ++i) {
    greedy.push_back(std::make_unique<TestClient>(daemon_->control_port()));
    if (!greedy.back()->join(hello)) break;
  }
  EXPECT_EQ(greedy.size(), 7u) << "six of eight, and one was refused";
  TestClient first = client(), second = client();
  EXPECT_TRUE(first.join(TestClient::hello(kScene)));
  EXPECT_TRUE(second.join(TestClient::hello(kScene)));
}

TEST_F(Waiting, WhyASceneDoesNotLoadNamesNoFolderOfTheServer) {
  start();
  testing::internal::CaptureStderr();
  TestClient c = client();
  c.send(TestClient::hello("broken.gltf"));
  const auto refused = c.receive_a<protocol::Refused>();
  const std::string log = testing::internal::GetCapturedStderr();
  ASSERT_TRUE(refused);
  EXPECT_TRUE(refused->text.starts_with("broken.gltf: ")) << refused->text;
  EXPECT_EQ(refused->text.find('/'), std::string::npos) << refused->text;
  EXPECT_NE(log.find((folder_ / "files/broken.gltf").string() + ": "), std::string::npos) << log;
}

}  // namespace
}  // namespace gnomon::daemon
