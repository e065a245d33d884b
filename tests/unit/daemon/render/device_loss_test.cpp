// What the render loop does without a device, and without memory on it.
#include "daemon/render/render_loop.h"

#include "daemon/render/light_importance.h"
#include "tests/unit/daemon/render/render_loop_fixture.h"

namespace gnomon::daemon {
namespace {

TEST_F(RenderLoopTest, ALostDeviceIsMadeAnewWithItsScenesAndSessionsGoOn) {
  view(kA, 1);
  view(kB, 1);
  settle();
  fake_->complete(1ms, true);
  settle();
  EXPECT_EQ(renderers_made_, 1) << "a frame is still on the old device";
  EXPECT_FALSE(loop_->device_up());
  view(kA, 2);
  fake_->complete(1ms, true);
  settle();
  EXPECT_EQ(renderers_made_, 2);
  EXPECT_TRUE(loop_->device_up());
  EXPECT_EQ(fake_->resident(), std::set<SceneId>{kScene});
  ASSERT_EQ(fake_->waiting(), 1u);
  fake_->complete();
  EXPECT_EQ(rendered_frames_of(kA), std::vector<uint32_t>{2});
  EXPECT_EQ(metrics_.count_of(Fault::device_lost), 2u);
}

TEST_F(RenderLoopTest, ADeviceThatIsLostTooOftenIsGivenUp) {
  for (uint32_t loss = 1; loss <= kMaxLosses + 1; ++loss) {
    EXPECT_FALSE(loop_->finished()) << loss;
    view(kA, loss);
    settle();
    fake_->complete(1ms, true);
    settle();
  }
  EXPECT_TRUE(loop_->finished());
  ASSERT_TRUE(loop_->failure());
  EXPECT_NE(loop_->failure()->message.find("lost 4 times within 60 s"), std::string::npos);
}

TEST_F(RenderLoopTest, LossesFarApartAreForgiven) {
  for (uint32_t loss = 1; loss <= 3 * kMaxLosses; ++loss) {
    view(kA, loss);
    settle();
    fake_->complete(1ms, true);
    settle();
    now_ += kLossWindow;
  }
  EXPECT_FALSE(loop_->failure());
}

TEST_F(RenderLoopTest, AFailedRebuildIsAFailure) {
  no_more_renderers_ = true;
  view(kA, 1);
  settle();
  fake_->complete(1ms, true);
  settle();
  ASSERT_TRUE(loop_->failure());
  EXPECT_EQ(loop_->failure()->message, "no device left");
  view(kA, 2);
  settle();  // nothing may be submitted while there is no renderer
}

TEST_F(RenderLoopTest, NoMemoryForAFrameMakesItSmallerAndNothingIsLost) {
  const SessionId large{44};
  open(large, {.width = 1600, .height = 800});
  fake_->most_pixels = 200 * 100;
  view(large, 1);
  view(kB, 1);
  settle();
  ASSERT_EQ(fake_->waiting(), 2u) << "the same view, and the neighbour's as ever";
  const size_t at = fake_->job(0).width == 16 ? 1 : 0;
  EXPECT_EQ(fake_->job(1 - at).width, 16u);
  EXPECT_EQ(fake_->job(at).width, 200u);
  EXPECT_EQ(fake_->job(at).height, 96u);
  ASSERT_FALSE(degraded_.empty());
  EXPECT_EQ(degraded_.back().message.width, 200);
  EXPECT_EQ(degraded_.back().message.reason, "the device has no memory for more");
  fake_->most_pixels = UINT32_MAX;
  for (uint32_t frame = 2; frame < 20; ++frame) {
    while (fake_->waiting() > 0) fake_->complete();
    rendered_.clear();
    settle();
    now_ += 2s;
    view(large, frame);
    settle();
  }
  EXPECT_EQ(fake_->job(0).width, 1600u) << "all of it again when there is room";
  EXPECT_EQ(metrics_.count_of(Fault::submit_failed), 0u);
  EXPECT_EQ(renderers_made_, 1);
}

TEST_F(RenderLoopTest, WithNoMemoryAtAllFramesAreLostAndNotTheDevice) {
  fake_->refuse_submits = true;
  for (uint32_t frame = 1; frame <= 100; ++frame) {
    view(kA, frame);
    settle();
  }
  EXPECT_EQ(metrics_.count_of(Fault::submit_failed), 100u);
  EXPECT_EQ(renderers_made_, 1);
  fake_->refuse_submits = false;
  view(kA, 101);
  settle();
  fake_->complete();
  EXPECT_EQ(rendered_frames_of(kA), std::vector<uint32_t>{101});
}

TEST_F(RenderLoopTest, AFrameThatTheDriverCouldNotStartIsLostAlone) {
  for (uint32_t frame = 1; frame <= 20; ++frame) {
    view(kA, frame);
    settle();
    fake_->refuse_to_start();
    settle();
  }
  EXPECT_EQ(metrics_.count_of(Fault::submit_failed), 20u);
  EXPECT_TRUE(loop_->device_up());
  EXPECT_EQ(renderers_made_, 1);
  EXPECT_EQ(fake_->free_slots(), kSlots);
  EXPECT_EQ(loop_->frames_out(), 0u);
  view(kA, 21);
  settle();
  fake_->complete();
  EXPECT_EQ(rendered_frames_of(kA), std::vector<uint32_t>{21});
}

}  // namespace
}  // namespace gnomon::daemon
