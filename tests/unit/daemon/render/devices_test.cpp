// A daemon with two devices: sessions are spread over them, and continue when one is lost, drained or beyond repair.
#include "daemon/ctl/admin_client.h"
#include "tests/unit/daemon/net/served.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

class TwoDevices : public Served {
 protected:
  static constexpr size_t kClients = 6;

  void SetUp() override {
    Served::SetUp();
    for (size_t d = 0; d < 2; ++d) make_renderers_.push_back([this, d] { return make(d); });
  }

  Result<std::unique_ptr<gpu::Renderer>> make(size_t device) {
    if (made_[device]++ > 0 && broken_) return Error{"no such device any more"};
    auto made = std::make_unique<SelfRunningFakeRenderer>(3, kLights, 0ms, lose_[device]);
    made->most_pixels = most_pixels_[device];
    renderers_[device] = made.get();
    return std::unique_ptr<gpu::Renderer>(std::move(made));
  }

  void join() {
    for (size_t i = 0; i < kClients; ++i) {
      clients_.push_back(std::make_unique<TestClient>(daemon_->control_port()));
      ASSERT_TRUE(clients_.back()->join(TestClient::hello(kScene)));
    }
  }

  void send(uint32_t frame) {
    for (size_t i = 0; i < clients_.size(); ++i) clients_[i]->send_view(frame, static_cast<float>(i));
  }
  void expect_frames(uint32_t frame) {
    send(frame);
    for (size_t i = 0; i < clients_.size(); ++i) {
      EXPECT_TRUE(is_frame_of(*clients_[i], clients_[i]->receive_frame(frame), static_cast<float>(i))) << i;
    }
  }

  ctl::AdminClient admin() { return ctl::AdminClient({.address = "unix:" + daemon_->admin().socket().string()}); }
  std::vector<int> sessions_by_device() {
    std::vector<int> all;
    const auto status = admin().status();
    for (const auto& device : status->at("devices")) all.push_back(device.at("sessions"));
    return all;
  }
  bool eventually_live(std::vector<int> sessions) {
    return eventually([&] { return sessions_by_device() == sessions; });
  }

  FakeRenderer* renderers_[2] = {};  // the newest
  std::atomic<int> made_[2] = {0, 0};
  std::atomic<bool> broken_{false};
  uint32_t most_pixels_[2] = {UINT32_MAX, UINT32_MAX};
  std::shared_ptr<std::atomic<bool>> lose_[2] = {std::make_shared<std::atomic<bool>>(false),
                                                 std::make_shared<std::atomic<bool>>(false)};
  std::vector<std::unique_ptr<TestClient>> clients_;
};

TEST_F(TwoDevices, ShareTheSessions) {
  start();
  join();
  EXPECT_TRUE(eventually_live({3, 3}));
  for (uint32_t frame = 1; frame <= 5; ++frame) expect_frames(frame);
  EXPECT_TRUE(metrics_say("gnomon_device_up{device=\"0\"} 1"));
  EXPECT_TRUE(metrics_say("gnomon_device_up{device=\"1\"} 1"));
  EXPECT_TRUE(eventually([&] { return metrics_say("gnomon_device_sessions{device=\"1\"} 3"); }));
  clients_.clear();
  EXPECT_TRUE(eventually_live({0, 0}));
}

TEST_F(TwoDevices, SessionsGoOnWhenOneIsLostAndComesBack) {
  start();
  join();
  expect_frames(1);
  *lose_[0] = true;
  send(2);
  ASSERT_TRUE(eventually([&] { return metrics_say("gnomon_device_losses_total{device=\"0\"} 1"); }));
  expect_frames(3);
  EXPECT_TRUE(eventually([&] { return made_[0] == 2; }));
  EXPECT_TRUE(eventually_live({3, 3})) << "it has sessions again";
  expect_frames(4);
  EXPECT_TRUE(metrics_say("gnomon_device_losses_total{device=\"1\"} 0"));
}

TEST_F(TwoDevices, SessionsGoOnWhenOneIsBeyondRepair) {
  start();
  join();
  expect_frames(1);
  broken_ = true;
  *lose_[1] = true;
  send(2);
  ASSERT_TRUE(eventually_live({6, 0}));
  expect_frames(3);
  EXPECT_TRUE(eventually([&] { return metrics_say("gnomon_device_up{device=\"1\"} 0"); }));
  EXPECT_EQ(admin().status()->at("ready"), true);
  TestClient late = client();
  EXPECT_TRUE(late.join(TestClient::hello(kScene)));
  EXPECT_TRUE(eventually_live({7, 0}));
  EXPECT_TRUE(admin().post("/scenes/triangle/load")) << "the device that is left has it";
}

TEST_F(TwoDevices, ADrainedOneHasNoSessions) {
  start();
  join();
  expect_frames(1);
  ASSERT_TRUE(admin().post("/devices/0/drain"));
  EXPECT_TRUE(eventually_live({0, 6}));
  expect_frames(2);
  const auto last = admin().post("/devices/1/drain");
  ASSERT_FALSE(last) << "it is the last one in service";
  EXPECT_NE(last.error().message.find("no other device takes sessions"), std::string::npos);
  ASSERT_TRUE(admin().post("/devices/0/resume"));
  EXPECT_TRUE(eventually_live({3, 3}));
  expect_frames(3);
  EXPECT_FALSE(admin().post("/devices/2/drain")) << "there are two";
}

TEST_F(TwoDevices, ThereIsRoomWhereOneThatTakesSessionsHasIt) {
  most_pixels_[0] = 100;
  start();
  for (int i = 0; i < 20; ++i) {
    TestClient c = client();
    ASSERT_TRUE(c.join(TestClient::hello(kScene))) << i;
  }
  ASSERT_TRUE(admin().post("/devices/1/drain"));
  TestClient late = client();
  late.send(TestClient::hello(kScene));
  const auto refused = late.receive_a<protocol::Refused>();
  ASSERT_TRUE(refused);
  EXPECT_EQ(refused->code, protocol::RefusalCode::over_capacity);
}

TEST_F(TwoDevices, ScenesComeToBothAndLeaveBoth) {
  start();
  ASSERT_TRUE(admin().post("/scenes/triangle/unload"));
  join();
  EXPECT_TRUE(eventually_live({3, 3}));
  expect_frames(1);
}

// A session may be placed on either, and may move.
TEST_F(TwoDevices, ASceneForWhichOneHasNoRoomIsOnNeither) {
  start();
  const auto account = [&] { return admin().status()->at("scene_memory").at("bytes").get<uint64_t>(); };
  const uint64_t before = account();
  renderers_[1]->takes_no_scenes = true;
  TestClient refused(daemon_->control_port());
  EXPECT_FALSE(refused.join(TestClient::hello("another.gltf")));
  EXPECT_TRUE(eventually([&] { return renderers_[0]->resident().size() == 1; })) << "the configured one";
  EXPECT_EQ(account(), before);
  renderers_[1]->takes_no_scenes = false;
  TestClient served(daemon_->control_port());
  EXPECT_TRUE(served.join(TestClient::hello("another.gltf")));
  EXPECT_EQ(renderers_[0]->resident().size(), 2u);
}

}  // namespace
}  // namespace gnomon::daemon
