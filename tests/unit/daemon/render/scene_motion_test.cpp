#include "daemon/render/scene_motion.h"

#include <gtest/gtest.h>

#include "tests/unit/daemon/render/fake_renderer.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using scenes::SceneTime;

constexpr SceneId kScene{3};

// A renderer whose background work is finished when the test says so.
class LightsFake : public FakeRenderer {
 public:
  LightsFake() : FakeRenderer(1) {}

  void set_lights(SceneId, std::vector<scenes::Light> lights, std::function<void(Result<void>)> changed,
                  std::function<void()>) override {
    asked.push_back(std::move(lights));
    waiting.push_back(std::move(changed));
  }
  void rebuild_lights(SceneId, std::function<void(Result<void>)> settled, std::function<void()>) override {
    ++settles;
    waiting.push_back(std::move(settled));
  }
  void finish_background() override {
    if (!allowed) return;
    for (auto& each : std::exchange(waiting, {})) each(answer);
  }
  gpu::LightState light_state(SceneId) const override { return state; }
  gpu::BuildProgress build_progress(SceneId) const override { return progress; }

  gpu::LightState state;
  gpu::BuildProgress progress;
  Result<void> answer;

  bool allowed = true;
  int settles = 0;
  std::vector<std::vector<scenes::Light>> asked;
  std::vector<std::function<void(Result<void>)>> waiting;
};

class SceneMotionTest : public testing::Test, private FrameSink {
 protected:
  void SetUp() override {
    device_ = std::move(*RenderDevice::open(
        [this]() -> Result<std::unique_ptr<gpu::Renderer>> {
          auto made = std::make_unique<LightsFake>();
          fake_ = made.get();
          return std::unique_ptr<gpu::Renderer>(std::move(made));
        },
        inbox_));
    motion_ = std::make_unique<SceneMotion>(*device_, metrics_, static_cast<FrameSink&>(*this));
    motion_->configure({10, 2s, start_});
    scene_->lights.resize(2);
  }

  void on_rendered(RenderedFrame) override {}
  void on_encoded(EncodedFrame) override {}
  void on_degraded(const SessionDegraded&) override {}
  void on_lights(const LightsUpdate& lights) override { announced_.push_back(lights); }

  void add() { motion_->add(kScene, "hall", {kScene, scene_, 0, 0}); }

  void change(SceneId scene, uint32_t light, const LightChange& change, TimePoint now) {
    motion_->change(scene, light, change, now, ++version_);
  }

  static LightChange at_height(float y) {
    LightChange change;
    change.position = glm::vec3(0, y, 0);
    return change;
  }

  const TimePoint start_ = TimePoint(1h);
  Metrics metrics_{{"default"}, {"hall"}, "test"};
  RenderInbox inbox_;
  LightsFake* fake_ = nullptr;
  std::unique_ptr<RenderDevice> device_;
  std::shared_ptr<scenes::Scene> scene_ = std::make_shared<scenes::Scene>();
  std::vector<LightsUpdate> announced_;
  uint32_t version_ = 0;
  std::unique_ptr<SceneMotion> motion_;
};

TEST_F(SceneMotionTest, WhatIsNotBuiltWhenASceneComesIsBuiltBesideTheFrames) {
  fake_->allowed = false;
  fake_->state = {0, 0, 2};
  add();
  EXPECT_EQ(fake_->settles, 1);
  EXPECT_TRUE(motion_->unbuilt(kScene));
  EXPECT_NE(metrics_.text().find("gnomon_scene_lights{scene=\"hall\",state=\"unbuilt\"} 2"), std::string::npos);
  fake_->progress = {{1, 0.5f}};
  EXPECT_EQ(motion_->report().at(kScene).built_share(), 0.75);
  EXPECT_TRUE(motion_->step(start_).empty());

  fake_->allowed = true;
  fake_->progress = {};
  fake_->state = {2, 0, 0};
  EXPECT_EQ(motion_->step(start_), std::vector{kScene}) << "its frames cost something else now";
  EXPECT_FALSE(motion_->unbuilt(kScene));
  EXPECT_EQ(motion_->report().at(kScene).built_share(), 1);
  EXPECT_TRUE(motion_->step(start_ + 1s).empty());
  EXPECT_NE(metrics_.text().find("gnomon_scene_light_rebuilds_total{scene=\"hall\"} 0"), std::string::npos)
      << "the first build is no rebuild";
}

TEST_F(SceneMotionTest, ABuildThatFailsIsToldAndTheHierarchyGoesOn) {
  fake_->state = {0, 0, 2};
  fake_->answer = Error{"no memory"};
  add();
  EXPECT_TRUE(motion_->step(start_).empty());
  EXPECT_TRUE(motion_->unbuilt(kScene));
  EXPECT_TRUE(motion_->report().at(kScene).failed);
  EXPECT_EQ(motion_->report().at(kScene).built_share(), 0);
  motion_->step(start_ + 59s);
  EXPECT_EQ(fake_->settles, 1);
  motion_->step(start_ + 60s);
  EXPECT_EQ(fake_->settles, 2) << "it may have been for want of memory";
  motion_->step(start_ + 61s);
  motion_->step(start_ + 180s);
  EXPECT_EQ(fake_->settles, 2) << "the second time it rests twice as long";
  fake_->answer = {};
  fake_->state = {2, 0, 0};
  motion_->step(start_ + 181s);
  EXPECT_EQ(fake_->settles, 3);
  EXPECT_EQ(motion_->step(start_ + 182s), std::vector{kScene});
  EXPECT_FALSE(motion_->report().at(kScene).failed);
  motion_->step(start_ + 24h);
  EXPECT_EQ(fake_->settles, 3);
}

TEST_F(SceneMotionTest, ALightThatIsChangedMeanwhileSettlesAfterwards) {
  fake_->allowed = false;
  fake_->state = {0, 0, 2};
  add();
  change(kScene, 0, at_height(2), start_);
  EXPECT_TRUE(motion_->step(start_ + 5s).empty());
  EXPECT_EQ(fake_->settles, 1) << "one build at a time";
  fake_->allowed = true;
  EXPECT_EQ(motion_->step(start_ + 6s), std::vector{kScene});
  EXPECT_EQ(fake_->settles, 2);
  motion_->step(start_ + 7s);
  EXPECT_NE(metrics_.text().find("gnomon_scene_light_rebuilds_total{scene=\"hall\"} 1"), std::string::npos);
}

TEST_F(SceneMotionTest, ADeviceMadeAnewBuildsAgainWhatItHasNot) {
  fake_->state = {0, 0, 2};
  add();
  motion_->step(start_);
  fake_->state = {0, 0, 2};
  motion_->restore();
  EXPECT_EQ(fake_->settles, 2);
  EXPECT_TRUE(motion_->unbuilt(kScene));
}

TEST_F(SceneMotionTest, ASceneThatComesTwiceKeepsItsLights) {
  add();
  change(kScene, 1, at_height(3), start_);
  motion_->step(start_);
  add();
  EXPECT_EQ(motion_->lights_of(kScene)[1].position.y, 3);
}

TEST_F(SceneMotionTest, ASceneWhoseLightsWereChangedBeforeIsShownWithThem) {
  int shown = 0;
  const auto show = [&](uint32_t version, float y) {
    std::vector<scenes::Light> lights(2);
    lights[1].position.y = y;
    motion_->show(kScene, {"hall", version, lights}, [&] { ++shown; });
  };
  add();
  show(0, 0);
  EXPECT_EQ(shown, 1) << "nobody has changed them";
  show(4, 3);
  show(4, 3);  // somebody else who asked for the scene
  EXPECT_EQ(shown, 1) << "no frame uses them yet";
  motion_->change(kScene, 1, at_height(2), start_, 4);
  motion_->step(start_);
  EXPECT_EQ(shown, 3);
  ASSERT_EQ(announced_.size(), 1u) << "they have that change";
  EXPECT_EQ(announced_[0].version, 4u);
  EXPECT_EQ(announced_[0].lights.at(1).position.y, 3);
  motion_->change(kScene, 1, at_height(5), start_, 5);
  motion_->step(start_);
  ASSERT_EQ(announced_.size(), 2u);
  EXPECT_EQ(announced_[1].lights.at(1).position.y, 5);
  show(4, 3);
  EXPECT_EQ(shown, 4);
  EXPECT_EQ(motion_->lights_of(kScene)[1].position.y, 5) << "what is older than what is shown";
}

TEST_F(SceneMotionTest, WhoWaitsForChangedLightsIsAnsweredWhenTheDeviceIsLost) {
  int shown = 0;
  fake_->allowed = false;
  add();
  motion_->show(kScene, {"hall", 1, std::vector<scenes::Light>(2)}, [&] { ++shown; });
  EXPECT_EQ(shown, 0);
  motion_->answer_waiting();
  EXPECT_EQ(shown, 1);
  fake_->allowed = true;
  motion_->step(start_);
  EXPECT_EQ(shown, 1);
}

TEST_F(SceneMotionTest, TheClockGoesInStepsAndAround) {
  scene_->moving_nodes.resize(1);
  scene_->period = 1500ms;
  add();
  EXPECT_EQ(motion_->time_of(kScene, start_), SceneTime(0));
  EXPECT_EQ(motion_->time_of(kScene, start_ + 99ms), SceneTime(0));
  EXPECT_EQ(motion_->time_of(kScene, start_ + 100ms), SceneTime(100ms));
  EXPECT_EQ(motion_->time_of(kScene, start_ + 1450ms), SceneTime(1400ms));
  EXPECT_EQ(motion_->time_of(kScene, start_ + 1650ms), SceneTime(100ms));
  EXPECT_EQ(motion_->moment_of(kScene, start_ + 250ms), (protocol::Moment{200'000, 0}));
}

TEST_F(SceneMotionTest, ScenesAtRestHaveNoMoment) {
  add();
  EXPECT_EQ(motion_->time_of(kScene, start_ + 5s), SceneTime(0));
  EXPECT_EQ(motion_->moment_of(kScene, start_ + 5s), std::nullopt);
  EXPECT_EQ(motion_->moment_of(SceneId{9}, start_ + 5s), std::nullopt);
}

TEST_F(SceneMotionTest, AChangedLightIsAnnouncedWhenItServesAndSettlesWhenItRests) {
  add();
  change(kScene, 1, at_height(3), start_);
  EXPECT_TRUE(announced_.empty());
  EXPECT_EQ(motion_->moment_of(kScene, start_), std::nullopt);
  motion_->step(start_);
  ASSERT_EQ(announced_.size(), 1u);
  EXPECT_EQ(announced_[0].scene, "hall");
  EXPECT_EQ(announced_[0].version, 1u);
  EXPECT_EQ(announced_[0].lights.at(1).position.y, 3);
  EXPECT_EQ(motion_->moment_of(kScene, start_), (protocol::Moment{0, 1}));
  motion_->step(start_ + 1999ms);
  EXPECT_EQ(fake_->settles, 0);
  motion_->step(start_ + 2s);
  EXPECT_EQ(fake_->settles, 1);
  motion_->step(start_ + 3s);
  EXPECT_NE(metrics_.text().find("gnomon_scene_light_rebuilds_total{scene=\"hall\"} 1"), std::string::npos);
  motion_->step(start_ + 60s);
  EXPECT_EQ(fake_->settles, 1) << "nothing has changed since";
}

TEST_F(SceneMotionTest, ChangesThatComeWhileOneIsAppliedGoTogether) {
  add();
  fake_->allowed = false;
  change(kScene, 0, at_height(1), start_);
  change(kScene, 0, at_height(2), start_);
  change(kScene, 1, at_height(5), start_);
  change(kScene, 7, at_height(5), start_);  // no such light
  EXPECT_EQ(fake_->asked.size(), 1u);
  fake_->allowed = true;
  motion_->step(start_);
  motion_->step(start_);
  ASSERT_EQ(announced_.size(), 2u);
  EXPECT_EQ(announced_[0].lights.at(0).position.y, 1);
  EXPECT_EQ(announced_[1].lights.at(0).position.y, 2);
  EXPECT_EQ(announced_[1].lights.at(1).position.y, 5);
}

TEST_F(SceneMotionTest, ALightThatMovesAgainWhileItSettlesSettlesAgain) {
  add();
  change(kScene, 0, at_height(1), start_);
  motion_->step(start_);
  fake_->allowed = false;
  motion_->step(start_ + 2s);
  EXPECT_EQ(fake_->settles, 1);
  change(kScene, 0, at_height(2), start_ + 3s);
  fake_->allowed = true;
  motion_->step(start_ + 3s);
  motion_->step(start_ + 4s);
  EXPECT_EQ(fake_->settles, 1);
  motion_->step(start_ + 5s);
  EXPECT_EQ(fake_->settles, 2);
}

TEST_F(SceneMotionTest, ADeviceMadeAnewGetsTheLightsAgain) {
  add();
  change(kScene, 0, at_height(1), start_);
  motion_->step(start_);
  ASSERT_TRUE(device_->rebuild(start_));
  motion_->restore();
  ASSERT_EQ(fake_->asked.size(), 1u);
  EXPECT_EQ(fake_->asked[0].at(0).position.y, 1);
}

}  // namespace
}  // namespace gnomon::daemon
