// Scenes are brought to a device in the background, and are served before their light buffers are built.
#include "tests/unit/daemon/render/render_loop_fixture.h"

namespace gnomon::daemon {
namespace {

constexpr SceneId kOther{7};

class ArrivalTest : public RenderLoopTest {
 protected:
  void arrive(SceneId scene = kOther) {
    loop_->handle(SceneLoaded{{scene, std::make_shared<scenes::Scene>(), 0, 0},
                              [this](Result<gpu::SceneFootprint> made) { answers_.push_back(made.has_value()); }},
                  now_);
  }
  // Renders a frame of kA at that cost.
  void render(uint32_t frame, Nanoseconds cost) {
    view(kA, frame);
    settle();
    fake_->complete(cost, false, cost);
    rendered_.clear();
    settle();
  }
  void let_go() {
    fake_->holds_scenes = fake_->holds_builds = false;
    settle();
  }

  std::vector<bool> answers_;
};

TEST_F(ArrivalTest, FramesGoOnWhileASceneIsOnItsWay) {
  fake_->holds_scenes = true;
  arrive();
  settle();
  view(kA, 1);
  settle();
  ASSERT_EQ(fake_->waiting(), 1u);
  fake_->complete();
  settle();
  EXPECT_EQ(rendered_frames_of(kA), std::vector<uint32_t>{1});
  EXPECT_TRUE(answers_.empty());
  let_go();
  EXPECT_EQ(answers_, std::vector{true});
  EXPECT_TRUE(fake_->resident().contains(kOther));
}

TEST_F(ArrivalTest, WhoeverAsksForASceneOnItsWayIsAnsweredWithTheFirst) {
  const int before = fake_->brought;
  fake_->holds_scenes = true;
  arrive();
  arrive();
  let_go();
  EXPECT_EQ(answers_, (std::vector{true, true}));
  EXPECT_EQ(fake_->brought, before + 1);
  arrive();
  EXPECT_EQ(answers_.size(), 3u);
  EXPECT_EQ(fake_->brought, before + 1) << "it is there";
}

TEST_F(ArrivalTest, ASceneOnItsWayComesToTheDeviceThatIsMadeAnew) {
  fake_->holds_scenes = true;
  arrive();
  view(kA, 1);
  settle();
  fake_->complete(1ms, true);
  settle();
  EXPECT_EQ(renderers_made_, 2);
  EXPECT_EQ(answers_, std::vector{true});
  EXPECT_TRUE(fake_->resident().contains(kOther));
}

TEST_F(ArrivalTest, WhereNoDeviceIsLeftWhoWaitsIsTold) {
  fake_->holds_scenes = true;
  arrive();
  no_more_renderers_ = true;
  view(kA, 1);
  settle();
  fake_->complete(1ms, true);
  settle();
  EXPECT_TRUE(loop_->failure());
  EXPECT_EQ(answers_, std::vector{false});
}

TEST_F(ArrivalTest, WhenTheServerStopsWhoWaitsIsTold) {
  fake_->holds_scenes = true;
  arrive();
  loop_->handle(StopRendering{}, now_);
  EXPECT_EQ(answers_, std::vector{false});
  let_go();
  EXPECT_EQ(answers_.size(), 1u);
  arrive();
  EXPECT_EQ(answers_, (std::vector{false, false}));
}

// Admission uses the cost of frames after the build, so that nobody is refused for their higher cost before it.
TEST_F(ArrivalTest, WhatFramesCostUntilTheBuildIsDoneIsLearnedApart) {
  constexpr Nanoseconds kBefore = 1500us, kAfter = 50us;  // too cheap to be cut
  loop_->handle(SceneUnloaded{kScene}, now_);
  fake_->state_of_lights.unbuilt = 2;
  fake_->holds_builds = true;
  arrive(kScene);
  for (uint32_t frame = 1; frame < 5; ++frame) render(frame, kBefore);
  EXPECT_FALSE(loop_->costs().contains(kScene) && loop_->costs().at(kScene).model(1).knows());
  view(kA, 5);
  settle();  // the frame is on the device when the build is finished
  let_go();
  fake_->complete(kBefore, false, kBefore);
  settle();
  EXPECT_FALSE(loop_->costs().contains(kScene) && loop_->costs().at(kScene).model(1).knows());
  render(6, kAfter);
  const scheduler::CostModel learned = loop_->costs().at(kScene).model(1);
  ASSERT_TRUE(learned.knows());
  EXPECT_LT(learned.predict({16 * 16, 16 * 16 * 2, true}).total(), 2 * kAfter);
}

}  // namespace
}  // namespace gnomon::daemon
