// Who waits for a scene, and what is read when nobody does any more. The reader is the test's; the devices never start, but
// where a test says so.
#include "daemon/scenes/scene_host.h"

#include <gtest/gtest.h>

#include <atomic>
#include <deque>
#include <semaphore>

#include "daemon/scenes/scene_fetches.h"
#include "gpu/tracers/light_buffer/builder.h"
#include "tests/unit/daemon/render/fake_renderer.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr TenantId kTenant{1};

// A reader that reads until it is told to fail, or until it is stopped.
class SlowReader {
 public:
  scenes::SceneReader reader() {
    return [this](const scenes::SceneSource&, const scenes::LoadLimits&,
                  const scenes::Watch& watch) -> Result<scenes::ScenePtr> {
      for (const double share : {0.25, 0.5, 0.4}) watch.on_share(share);
      ++begun_;
      begun_.notify_all();
      std::binary_semaphore over{0};
      const std::stop_callback wake(watch.stop, [&] { over.release(); });
      over.acquire();
      return Error{"stopped"};
    };
  }
  void wait_for(int readings) {
    for (int now = begun_; now < readings; now = begun_) begun_.wait(now);
  }
  int begun() const { return begun_; }

 private:
  std::atomic<int> begun_ = 0;
};

class Answer {
 public:
  SceneHost::Ready ready() {
    return [this](const Result<SceneForUse>& scene) {
      text_ = scene ? "a scene" : scene.error().message;
      arrived_.release();
    };
  }
  std::string wait() {
    arrived_.acquire();
    return text_;
  }
  bool there() { return arrived_.try_acquire(); }

 private:
  std::string text_;
  std::binary_semaphore arrived_{0};
};

struct Host {
  Host() {
    ScenesConfig config;
    for (const char* name : {"a", "b", "c", "d", "e"}) {
      SceneFile& scene = config.list.emplace_back();
      scene.name = name;
      scene.file = "absent.glb";
    }
    auto read = SceneCatalog::read(config);
    EXPECT_TRUE(read);
    catalog = std::move(*read);
    host.emplace(catalog, devices, lights, metrics, slow.reader());
  }

  SlowReader slow;
  SceneCatalog catalog;
  Metrics metrics{{"default", "other"}, {"a"}, "test", 1};
  Health health;
  DevicePool devices{1, 30.0, metrics, health};
  SceneLights lights{devices, {}, {}};
  std::optional<SceneHost> host;
};

TEST(SceneHost, AReaderIsStoppedWhenTheLastOneGivesUp) {
  Host to;
  Answer first, second;
  const FetchId one = to.host->fetch("a", first.ready(), kTenant);
  to.slow.wait_for(1);
  const FetchId two = to.host->fetch("a", second.ready(), kTenant);
  to.host->give_up(one);
  EXPECT_EQ(first.wait(), "nobody waits for it any more");
  EXPECT_FALSE(second.there()) << "somebody waits still";
  to.host->give_up(two);
  EXPECT_EQ(second.wait(), "nobody waits for it any more");
  Answer third;  // its reader can only begin when a loader is free of the stopped one, or beside it
  to.host->fetch("a", third.ready(), kTenant);
  to.slow.wait_for(2);
}

TEST(SceneHost, WhoGivesUpWhileALoaderTakesTheRequestIsFound) {
  Host to;
  std::deque<Answer> answers(400);
  for (size_t i = 0; i < answers.size(); ++i) {
    const FetchId fetch = to.host->fetch("a", answers[i].ready(), kTenant);
    for (size_t spin = 0; spin < (i * 37) % 2000; ++spin) std::atomic_signal_fence(std::memory_order_seq_cst);
    to.host->give_up(fetch);
  }
  for (Answer& answer : answers) ASSERT_EQ(answer.wait(), "nobody waits for it any more");
}

TEST(SceneHost, SaysHowFarAReadingIsAndNeverLess) {
  Host to;
  Answer answers[3];
  for (int i = 0; i < 3; ++i) to.host->fetch(std::string(1, "abc"[i]), answers[i].ready(), kTenant);
  to.slow.wait_for(2);
  EXPECT_EQ(under_way(*to.host, "a")->share, 0.5);
  EXPECT_EQ(under_way(*to.host, "b")->share, 0.5);
  EXPECT_EQ(under_way(*to.host, "c")->share, std::nullopt) << "it is not read yet";
  EXPECT_EQ(under_way(*to.host, "d"), std::nullopt);
}

TEST(SceneHost, WhatNobodyWaitsForIsNotRead) {
  Host to;
  Answer answers[3];
  to.host->fetch("a", answers[0].ready(), kTenant);
  to.host->fetch("b", answers[1].ready(), kTenant);
  to.slow.wait_for(2);  // as many as one tenant may have at work
  const FetchId waiting = to.host->fetch("c", answers[2].ready(), kTenant);
  to.host->give_up(waiting);
  EXPECT_EQ(answers[2].wait(), "nobody waits for it any more");
  EXPECT_EQ(to.slow.begun(), 2);
}

TEST(SceneHost, AnotherTenantsSceneIsReadBesideSlowOnes) {
  Host to;
  Answer answers[5];
  int i = 0;
  for (const char* name : {"a", "b", "c", "d"}) to.host->fetch(name, answers[i++].ready(), kTenant);
  to.slow.wait_for(2);
  to.host->fetch("e", answers[4].ready(), TenantId{0});
  to.slow.wait_for(3);
}

TEST(SceneHost, AStoppedReadingIsNoRefusal) {
  Host to;
  Answer first, second;
  to.host->give_up(to.host->fetch("a", first.ready(), kTenant));
  first.wait();
  to.host->fetch("a", second.ready(), kTenant);
  to.slow.wait_for(1);
  EXPECT_FALSE(second.there());
}

// What is refused after it was read is not kept.
class RefusedScene : public ::testing::Test {
 protected:
  scenes::SceneReader reader(size_t lights) {
    return [this, lights](const auto&, const auto&, const auto&) -> Result<scenes::ScenePtr> {
      ++readings_;
      auto scene = std::make_shared<scenes::Scene>();
      scene->lights.resize(lights);
      last_ = scene;
      return scenes::ScenePtr(scene);
    };
  }
  std::string fetch(Host& to) {
    Answer answer;
    to.host->fetch("a", answer.ready(), kTenant);
    const std::string text = answer.wait();
    // The loader lets go of it after the answer.
    while (!last_.expired() && kept_for_ms_ < 10'000) {
      std::this_thread::sleep_for(1ms);
      ++kept_for_ms_;
    }
    return text;
  }

  std::atomic<int> readings_ = 0;
  int kept_for_ms_ = 0;
  std::weak_ptr<const scenes::Scene> last_;
};

TEST_F(RefusedScene, WithoutLightsIsReadOnceAndLetGo) {
  Host to;
  to.host.emplace(to.catalog, to.devices, to.lights, to.metrics, reader(0));
  EXPECT_EQ(fetch(to), kNoLights);
  EXPECT_TRUE(last_.expired());
  EXPECT_EQ(fetch(to), kNoLights);
  EXPECT_EQ(readings_, 1) << "the refusal is remembered";
  EXPECT_EQ(to.host->memory().bytes, 0u);
}

// The devices never take it: what is read stays on its way to them.
TEST_F(RefusedScene, NoFurtherSceneOfATenantIsReadBeforeOneIsResident) {
  Host to;
  to.host.emplace(to.catalog, to.devices, to.lights, to.metrics, reader(1));
  Answer answers[4];
  const auto is_prepared = [&](const char* name) {
    return under_way(*to.host, name)->stage == SceneUnderWay::Stage::preparing;
  };
  const auto wait_for = [&](const char* name) {
    for (int i = 0; i < 10'000 && !is_prepared(name); ++i) std::this_thread::sleep_for(1ms);
    EXPECT_TRUE(is_prepared(name)) << name;
  };
  for (int i = 0; i < 3; ++i) to.host->fetch(std::string(1, "abc"[i]), answers[i].ready(), kTenant);
  wait_for("a");
  wait_for("b");
  to.host->fetch("d", answers[3].ready(), TenantId{0});
  wait_for("d");
  EXPECT_EQ(under_way(*to.host, "c")->stage, SceneUnderWay::Stage::queued);
  EXPECT_EQ(readings_, 3);
}

TEST_F(RefusedScene, WhoAsksForASceneOnItsWayTakesNoPlace) {
  Host to;
  to.host.emplace(to.catalog, to.devices, to.lights, to.metrics, reader(1));
  Answer answers[4];
  const auto wait_for = [&](const char* name) {
    for (int i = 0; i < 10'000 && under_way(*to.host, name)->stage != SceneUnderWay::Stage::preparing; ++i) {
      std::this_thread::sleep_for(1ms);
    }
    EXPECT_EQ(under_way(*to.host, name)->stage, SceneUnderWay::Stage::preparing) << name;
  };
  to.host->fetch("a", answers[0].ready(), kTenant);
  wait_for("a");
  for (int i = 1; i < 3; ++i) to.host->fetch("a", answers[i].ready(), kTenant);
  to.host->fetch("b", answers[3].ready(), kTenant);
  wait_for("b");
}

struct NoFrames final : FrameSink {
  void on_rendered(RenderedFrame) override {}
  void on_encoded(EncodedFrame) override {}
  void on_degraded(const SessionDegraded&) override {}
  void on_lights(const LightsUpdate&) override {}
};

// On a device with room a scene counts with what its light buffers may take there.
TEST_F(RefusedScene, CountsWithTheRoomForLightBuffersThatItsDeviceHas) {
  constexpr uint64_t kRoom = uint64_t{1000} << 20;
  uint64_t counted[2];
  for (const bool has_room : {false, true}) {
    Host to;
    to.host.emplace(to.catalog, to.devices, to.lights, to.metrics, reader(1));
    NoFrames sink;
    const RendererFactory factory = [has_room] {
      auto renderer = std::make_unique<FakeRenderer>(2, 1);
      if (has_room) renderer->light_buffer_room = kRoom;
      return std::unique_ptr<gpu::Renderer>(std::move(renderer));
    };
    ASSERT_TRUE(to.devices.start({factory}, {}, {}, sink, [](const Error&) {}));
    Answer answer;
    to.host->fetch("a", answer.ready(), kTenant);
    EXPECT_EQ(answer.wait(), "a scene");
    counted[has_room ? 1 : 0] = to.host->memory().bytes;
    to.devices.stop();
  }
  EXPECT_EQ(counted[1] - counted[0], kRoom - gpu::light_buffer::default_budget(1));
}

TEST(SceneHost, EndsBesideReadersThatAreAtWork) {
  Host to;
  Answer answer;
  to.host->fetch("a", answer.ready(), kTenant);
  to.slow.wait_for(1);
  to.host.reset();
  EXPECT_NE(answer.wait(), "a scene");
}

}  // namespace
}  // namespace gnomon::daemon
