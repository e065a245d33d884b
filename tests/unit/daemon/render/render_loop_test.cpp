#include "daemon/render/render_loop.h"

#include "daemon/render/light_importance.h"
#include "tests/unit/daemon/render/render_loop_fixture.h"

namespace gnomon::daemon {
namespace {

TEST_F(RenderLoopTest, NewestCameraWinsAndTheOthersAreCounted) {
  for (uint32_t frame = 1; frame <= kSlots; ++frame) {  // fill the device
    view(kB, frame);
    settle();
  }
  for (uint32_t frame = 1; frame <= 5; ++frame) view(kA, frame);
  settle();
  EXPECT_EQ(fake_->waiting(), kSlots);
  fake_->complete();
  rendered_.clear();  // drops the lease: a slot is free
  settle();
  ASSERT_EQ(fake_->waiting(), kSlots);
  EXPECT_EQ(fake_->job(1).camera.position.x, 5.0f);
  fake_->complete();
  fake_->complete();
  EXPECT_EQ(rendered_frames_of(kA), std::vector<uint32_t>{5});
  EXPECT_EQ(rendered_.back().meta.coalesced, 4u);
  EXPECT_NE(metrics_.text().find("gnomon_frames_coalesced_total{tenant=\"default\"} 4"), std::string::npos);
}

TEST_F(RenderLoopTest, ASilentSessionHoldsNobodyUp) {
  for (uint32_t frame = 1; frame <= 50; ++frame) {
    view(kA, frame);
    view(kB, frame);
    settle();
    ASSERT_EQ(fake_->waiting(), 2u);
    fake_->complete();
    fake_->complete();
    EXPECT_EQ(rendered_frames_of(kA), std::vector<uint32_t>{frame});
    EXPECT_EQ(rendered_frames_of(kB), std::vector<uint32_t>{frame});
    rendered_.clear();
    settle();
  }
}

TEST_F(RenderLoopTest, NeverSubmitsMoreThanTheSlots) {
  for (uint64_t i = 100; i < 120; ++i) {
    open(SessionId{i});
    view(SessionId{i}, 1);
  }
  settle();
  EXPECT_EQ(fake_->waiting(), kSlots);
  fake_->complete();  // the frame is finished, but its lease is not dropped
  settle();
  EXPECT_EQ(fake_->waiting(), kSlots - 1);
  rendered_.clear();
  settle();
  EXPECT_EQ(fake_->waiting(), kSlots);
}

TEST_F(RenderLoopTest, FramesCarryWhatLaterStagesNeed) {
  const TimePoint arrival = now_;
  view(kA, 7);
  now_ += 3ms;
  settle();
  fake_->complete(4ms);
  ASSERT_EQ(rendered_.size(), 1u);
  const FrameMeta& meta = rendered_[0].meta;
  EXPECT_EQ(meta.times.arrival, arrival);
  EXPECT_EQ(meta.times.submitted, arrival + 3ms);
  EXPECT_EQ(meta.times.gpu, Nanoseconds(4ms));
  EXPECT_EQ(meta.spec.grid, rendered_[0].mask.mask().grid);
  gpu::CameraView camera;
  camera.position.x = 7;
  EXPECT_EQ(unpacked(rendered_[0].mask.mask())[0], fake_word(camera, 0));
}

TEST_F(RenderLoopTest, ANumberThatWrapsIsNewerThanTheLast) {
  for (uint32_t frame = 1; frame <= kSlots; ++frame) {
    view(kB, frame);
    settle();
  }
  view(kA, std::numeric_limits<uint32_t>::max());
  view(kA, 3);
  view(kA, std::numeric_limits<uint32_t>::max() - 1);  // overtaken on the way
  std::vector<FrameId> answered;
  while (fake_->waiting() > 0) {
    fake_->complete();
    for (const RenderedFrame& frame : rendered_) {
      if (frame.meta.route.session == kA) answered.push_back(frame.meta.route.frame);
    }
    rendered_.clear();
    settle();
  }
  EXPECT_EQ(answered, std::vector{FrameId{3}});
}

TEST_F(RenderLoopTest, AClosedSessionsViewIsDropped) {
  for (uint32_t frame = 1; frame <= kSlots; ++frame) {
    view(kB, frame);
    settle();
  }
  view(kA, 1);
  loop_->handle(SessionClosed{kA}, now_);
  view(kA, 2);  // a view that was sent before
  while (fake_->waiting() > 0) {
    fake_->complete();
    rendered_.clear();
    settle();
  }
  EXPECT_EQ(metrics_.count_of(Fault::session_gone), 2u);
  view(kB, 9);
  settle();
  ASSERT_EQ(fake_->waiting(), 1u);
  EXPECT_EQ(fake_->job(0).camera.position.x, 9.0f);
}

TEST_F(RenderLoopTest, ASessionMayCloseWhileItsFrameIsOnTheDevice) {
  view(kA, 1);
  settle();
  loop_->handle(SessionClosed{kA}, now_);
  fake_->complete();
  rendered_.clear();
  settle();
  EXPECT_EQ(fake_->free_slots(), kSlots);
}

TEST_F(RenderLoopTest, StopsWhenTheLastLeaseHasComeBack) {
  view(kA, 1);
  settle();
  view(kB, 1);
  loop_->handle(StopRendering{}, now_);
  EXPECT_FALSE(loop_->finished());
  fake_->complete();
  settle();
  EXPECT_FALSE(loop_->finished()) << "the lease is still out";
  rendered_.clear();
  settle();
  EXPECT_TRUE(loop_->finished());
  EXPECT_EQ(fake_->waiting(), 0u) << "the view that was pending is not rendered";
  view(kB, 2);
  EXPECT_EQ(metrics_.count_of(Fault::view_draining), 2u);
}

TEST_F(RenderLoopTest, APolicyChangesWithViewsWaitingAndOnTheDevice) {
  for (const char* policy : {"fair", "priority", "deadline", "round_robin"}) {
    view(kA, 1);
    settle();
    view(kB, 1);
    SharingPolicy sharing = sharing_policy_of({});
    sharing.policy = policy;
    loop_->handle(SharingPolicyChanged{sharing}, now_);
    settle();
    while (fake_->waiting() > 0) {
      fake_->complete();
      settle();
    }
    EXPECT_EQ(rendered_frames_of(kA).size(), 1u) << policy;
    EXPECT_EQ(rendered_frames_of(kB).size(), 1u) << policy;
    rendered_.clear();
    settle();
  }
}

TEST_F(RenderLoopTest, ATenantsRateIsKept) {
  SharingPolicy sharing = sharing_policy_of({});
  sharing.tenants[0].rates.buffers_per_second = 50;
  loop_->handle(SharingPolicyChanged{sharing}, now_);
  const size_t frames = frames_in_2s(kA);
  EXPECT_NEAR(static_cast<double>(frames), 2 * 50 + 5, 2) << "and a burst of 100 ms";
  EXPECT_LT(loop_->wake_at(), TimePoint::max());
}

TEST_F(RenderLoopTest, ATenantsShareOfTheDeviceHasACeiling) {
  SharingPolicy sharing = sharing_policy_of({});
  sharing.tenants[0].rates.gpu_share = 0.2;
  loop_->handle(SharingPolicyChanged{sharing}, now_);
  const size_t frames = frames_in_2s(kA);
  EXPECT_NEAR(static_cast<double>(frames), 2 * 200 + 20, 5) << "of 1 ms each, and a burst of 100 ms at that share";
}

TEST_F(RenderLoopTest, ATenantsBytesAreCounted) {
  SharingPolicy sharing = sharing_policy_of({});
  sharing.tenants[0].rates.bytes_per_second = 1000;
  loop_->handle(SharingPolicyChanged{sharing}, now_);
  loop_->handle(BytesSent{kTenant, kScene, 1000, 2000}, now_);
  view(kA, 1);
  settle();
  EXPECT_EQ(fake_->waiting(), 0u);
  now_ = loop_->wake_at();
  settle();
  EXPECT_EQ(fake_->waiting(), 1u);
}

TEST_F(RenderLoopTest, AGrantedRateIsKept) {
  const SessionId slow{77};
  open(slow, {.width = 16, .height = 16, .rate_hz = 20});
  const size_t frames = frames_in_2s(slow);
  EXPECT_NEAR(static_cast<double>(frames), 2 * 20 + 1, 2);
}

TEST_F(RenderLoopTest, AViewThatCannotBeReadyInTimeCostsNothing) {
  SharingPolicy sharing = sharing_policy_of({});
  sharing.policy = "deadline";
  loop_->handle(SharingPolicyChanged{sharing}, now_);
  loop_->handle(ViewRequest{kA, FrameId{1}, {}, now_, now_ - 1ms}, now_);
  loop_->handle(ViewRequest{kB, FrameId{1}, {}, now_, now_ + 1s}, now_);
  settle();
  EXPECT_EQ(fake_->waiting(), 1u);
  EXPECT_EQ(metrics_.count_of(Fault::deadline_unreachable), 1u);
  EXPECT_NE(metrics_.text().find("gnomon_tenant_frames_dropped_total{reason=\"deadline\",tenant=\"default\"} 1"),
            std::string::npos);
}

// A session that asks for more than the device can do: its rate falls, then its size, the client is notified of both,
// and both recover.
class OverloadTest : public RenderLoopTest {
 protected:
  static constexpr SessionId kBusy{88};

  void SetUp() override {
    RenderLoopTest::SetUp();
    SharingPolicy sharing = sharing_policy_of({});
    sharing.tenants[0].degradation = {.least_rate = 0.5, .least_size = 0.5};
    loop_->handle(SharingPolicyChanged{sharing}, now_);
    open(kBusy, {.width = 160, .height = 96, .rate_hz = 40});
  }

  // A second in which a view comes every 25 ms and every n-th is answered.
  void second(uint32_t answered_of) {
    for (uint32_t i = 0; i < 40; ++i) {
      view(kBusy, ++frame_);
      if (i % answered_of == 0) {
        settle();
        while (fake_->waiting() > 0) {
          last_ = fake_->job(0);
          fake_->complete();
        }
        rendered_.clear();
      }
      settle();
      now_ += 23ms;
    }
    loop_->review_sessions(1s);
  }

  uint32_t frame_ = 0;
  gpu::RenderJob last_;
};

TEST_F(OverloadTest, LessIsToldAndMoreAgain) {
  for (int i = 0; i < 20; ++i) second(8);
  ASSERT_FALSE(degraded_.empty());
  EXPECT_EQ(degraded_.front().message.width, 160) << "the rate first";
  EXPECT_EQ(degraded_.front().message.rate_hz, 30);
  EXPECT_LT(degraded_.back().message.width, 160);
  EXPECT_GE(degraded_.back().message.width, 80);
  EXPECT_GE(degraded_.back().message.rate_hz, 20);
  EXPECT_EQ(last_.width, degraded_.back().message.width) << "told what is in force";
  for (int i = 0; i < 200; ++i) second(1);
  EXPECT_EQ(degraded_.back().message.width, 160);
  EXPECT_EQ(degraded_.back().message.rate_hz, 40);
  EXPECT_EQ(last_.width, 160u);
}

TEST_F(OverloadTest, ARateThatMayNoLongerFallRisesAtOnce) {
  for (int i = 0; i < 20; ++i) second(8);
  ASSERT_LT(degraded_.back().message.rate_hz, 40);
  SharingPolicy sharing = sharing_policy_of({});
  sharing.tenants[0].degradation = {.least_rate = 1, .least_size = 0.5};
  loop_->handle(SharingPolicyChanged{sharing}, now_);
  EXPECT_EQ(degraded_.back().message.rate_hz, 40);
}

TEST_F(OverloadTest, AfterAMoveTheClientIsToldWhatItIsServedThere) {
  for (int i = 0; i < 20; ++i) second(8);
  RenderInbox there;
  std::vector<RenderEvent> events;
  loop_->handle(SessionMoved{kSilent, &there}, now_);
  there.take(events, TimePoint::min());
  EXPECT_TRUE(events.empty()) << "its client expects what was granted";
  loop_->handle(SessionMoved{kBusy, &there}, now_);
  there.take(events, TimePoint::min());
  open(kBusy, {.width = 160, .height = 96, .rate_hz = 40});  // the same loop stands for the other device's
  degraded_.clear();
  for (RenderEvent& event : events) loop_->handle(std::move(event), now_);
  ASSERT_EQ(degraded_.size(), 1u);
  EXPECT_EQ(degraded_[0].message.width, 160);
  EXPECT_EQ(degraded_[0].message.rate_hz, 40);
}

TEST_F(OverloadTest, LightsGoLastAndTheNearestStay) {
  constexpr SceneId kLit{7};
  auto scene = std::make_shared<scenes::Scene>();
  for (const float x : {100.0f, 0.0f, 50.0f}) scene->lights.emplace_back().position = {x, 0, 0};
  loop_->handle(SceneLoaded{{kLit, scene, 0, 0}, [](Result<gpu::SceneFootprint>) {}}, now_);
  SharingPolicy sharing = sharing_policy_of({});
  sharing.tenants[0].degradation = {.least_rate = 0.75, .least_size = 1, .least_lights = 0.3};
  loop_->handle(SharingPolicyChanged{sharing}, now_);
  loop_->handle(SessionClosed{kBusy}, now_);
  open(kBusy, {.width = 160, .height = 96, .rate_hz = 40, .scene = kLit, .lights = 3});
  for (int i = 0; i < 30; ++i) second(8);  // the camera stands at x = the frame's number, 1,000 and more
  ASSERT_FALSE(degraded_.empty());
  EXPECT_EQ(degraded_.front().message.rate_hz, 30) << "the rate first";
  EXPECT_TRUE(degraded_.front().message.untraced_lights.empty());
  EXPECT_EQ(degraded_.back().message.untraced_lights, (std::vector<uint16_t>{1, 2}))
      << "the first light is the nearest";
  EXPECT_EQ(last_.untraced, gpu::LightSet(0b110)) << "told what is in force";
  for (int i = 0; i < 200; ++i) second(1);
  EXPECT_TRUE(degraded_.back().message.untraced_lights.empty());
  EXPECT_TRUE(last_.untraced.none());
}

TEST(LightImportance, DistanceCountsAndPlacesAreNotChangedForLittle) {
  std::vector<scenes::Light> lights(2);
  lights[1].position = {10, 0, 0};
  const auto left_out = [&](float x, const gpu::LightSet& before) {
    return least_important(lights, {x, 0, 0}, 1, before);
  };
  const gpu::LightSet first(0b01), second(0b10);
  EXPECT_EQ(left_out(2, {}), second);
  EXPECT_EQ(left_out(8, {}), first);
  EXPECT_EQ(left_out(5.2f, second), second) << "a little nearer to the second";
  EXPECT_EQ(left_out(4.8f, first), first);
  EXPECT_EQ(left_out(8, second), first);
  lights[0].intensity = 1000;
  EXPECT_EQ(left_out(8, first), second);
  lights[0].range = 1;
  EXPECT_EQ(left_out(8, second), first) << "out of its range";
}

TEST(RenderInbox, BoundsWaitingViewsAndNothingElse) {
  RenderInbox inbox(3);
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(inbox.push_view({}));
  EXPECT_FALSE(inbox.push_view({}));
  for (int i = 0; i < 10; ++i) EXPECT_TRUE(inbox.push(SessionClosed{}));
  std::vector<RenderEvent> batch;
  inbox.take(batch, TimePoint::min());
  EXPECT_EQ(batch.size(), 13u);
  EXPECT_TRUE(inbox.push_view({}));
}

}  // namespace
}  // namespace gnomon::daemon
