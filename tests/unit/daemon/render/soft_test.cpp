// Soft shadows in the render loop: how many sample points frames have, what they are told to cost, and when there are
// fewer.
#include "tests/unit/daemon/render/render_loop_fixture.h"

namespace gnomon::daemon {
namespace {

constexpr SessionId kSoft{77};

// Two lights, of which the second is an area light.
class SoftTest : public RenderLoopTest {
 protected:
  SoftTest() { areas_ = {false, true}; }

  SessionGrant grant(SampleCounts samples) const {
    return {.width = 160,
            .height = 96,
            .rate_hz = 40,
            .samples = samples,
            .features = protocol::kFeatureSoft | protocol::kFeatureSizes,
            .scene = kScene,
            .lights = 2,
            .areas = {false, true}};
  }

  // The job of one frame, which costs `cost`.
  gpu::RenderJob frame(SessionId session, Nanoseconds cost = 1ms) {
    view(session, ++frame_);
    settle();
    if (fake_->waiting() == 0) return {};
    const gpu::RenderJob job = fake_->job(0);
    while (fake_->waiting() > 0) fake_->complete(cost);
    settle();
    return job;
  }

  // A second in which a view comes every 25 ms and every n-th is answered.
  void second(uint32_t answered_of) {
    for (uint32_t i = 0; i < 40; ++i) {
      view(kSoft, ++frame_);
      if (i % answered_of == 0) {
        settle();
        while (fake_->waiting() > 0) {
          last_ = fake_->job(0);
          fake_->complete();
        }
        for (RenderedFrame& rendered : std::exchange(rendered_, {})) spec_ = rendered.meta.spec;
      }
      settle();
      now_ += 23ms;
    }
    loop_->review_sessions(1s);
  }

  uint32_t frame_ = 0;
  gpu::RenderJob last_;
  FrameSpec spec_;
};

TEST_F(SoftTest, FramesHaveTheGrantedSamplesAndTheirPlanes) {
  for (const uint8_t samples : {1, 4, 16}) {
    open(kSoft, grant(samples));
    EXPECT_EQ(frame(kSoft).samples, samples);
    ASSERT_FALSE(rendered_.empty());
    const FrameSpec& spec = rendered_.back().meta.spec;
    EXPECT_EQ(spec.samples, samples);
    EXPECT_FALSE(spec.tells_samples);
    EXPECT_EQ(spec.grid.planes, samples == 1 ? 2u : samples == 4 ? 4u : 6u);
    EXPECT_EQ(spec.grid, rendered_.back().mask.mask().grid);
    EXPECT_EQ(spec.traced_bits, scheduler::weighted_bits(160 * 96, 2, 1, samples));
    loop_->handle(SessionClosed{kSoft}, now_);
    rendered_.clear();
  }
}

TEST_F(SoftTest, SamplesGoAfterTheRateAndComeBack) {
  open(kSoft, grant(16));
  SharingPolicy sharing = sharing_policy_of({});
  sharing.tenants[0].degradation = {.least_rate = 0.75, .least_size = 0.5};
  loop_->handle(SharingPolicyChanged{sharing}, now_);
  for (int i = 0; i < 30; ++i) second(8);
  ASSERT_GE(degraded_.size(), 4u);
  EXPECT_EQ(degraded_[0].message.rate_hz, 30) << "the rate first";
  EXPECT_EQ(degraded_[0].message.samples, 16);
  EXPECT_EQ(degraded_[1].message.samples, 4);
  EXPECT_EQ(degraded_[2].message.samples, 1);
  EXPECT_EQ(degraded_[2].message.width, 160) << "then the samples";
  EXPECT_LT(degraded_[3].message.width, 160) << "then the size";
  EXPECT_EQ(last_.samples, 1u) << "told what is in force";
  EXPECT_TRUE(spec_.tells_samples);
  EXPECT_EQ(spec_.grid.planes, 2u);
  for (int i = 0; i < 300; ++i) second(1);
  EXPECT_FALSE(spec_.tells_samples);
  EXPECT_EQ(degraded_.back().message.samples, 16);
  EXPECT_EQ(degraded_.back().message.width, 160);
  EXPECT_EQ(last_.samples, 16u);
}

TEST_F(SoftTest, OcclusionGoesInTwoStepsAndComesBack) {
  const SampleCounts full{1, Occlusion::full};
  open(kSoft, grant(full));
  SharingPolicy sharing = sharing_policy_of({});
  sharing.tenants[0].degradation = {.least_rate = 0.75, .least_size = 1};
  loop_->handle(SharingPolicyChanged{sharing}, now_);
  for (int i = 0; i < 30; ++i) second(8);
  ASSERT_GE(degraded_.size(), 3u);
  EXPECT_EQ(degraded_[0].message.samples, to_byte(full)) << "the rate first";
  EXPECT_EQ(degraded_[1].message.samples, to_byte({1, Occlusion::half}));
  EXPECT_EQ(degraded_[2].message.samples, to_byte({1}));
  EXPECT_EQ(last_.samples, SampleCounts{});
  for (int i = 0; i < 300; ++i) second(1);
  EXPECT_EQ(degraded_.back().message.samples, to_byte(full));
  EXPECT_EQ(last_.samples, full);
  EXPECT_FALSE(spec_.tells_samples);
}

TEST_F(SoftTest, FewerSamplesAreNotToldToAClientThatKnowsNone) {
  SessionGrant hard = grant(1);
  hard.features = 0;
  open(kSoft, hard);
  for (int i = 0; i < 10; ++i) second(8);
  ASSERT_FALSE(degraded_.empty());
  for (const SessionDegraded& each : degraded_) EXPECT_EQ(each.message.samples, 0);
}

TEST_F(SoftTest, EachNumberOfSamplesLearnsItsCost) {
  constexpr SessionId kHard{78};
  for (const SessionId session : {kSoft, kHard}) {
    SessionGrant unlimited = grant(session == kSoft ? 16 : 1);
    unlimited.rate_hz = 0;
    open(session, unlimited);
  }
  for (int i = 0; i < 20; ++i) {
    frame(kHard, 100us);
    frame(kSoft, 900us);
    rendered_.clear();
  }
  const scheduler::SampleCosts& costs = loop_->costs().at(kScene);
  const auto cost = [&](uint32_t samples) {
    const scheduler::Work work{160 * 96, scheduler::weighted_bits(160 * 96, 2, 1, samples), true};
    return to_seconds(costs.model(samples).predict(work).total());
  };
  EXPECT_NEAR(cost(1), 100e-6, 5e-6);
  EXPECT_NEAR(cost(16), 900e-6, 45e-6);
  EXPECT_NEAR(cost(4), 100e-6 * 2.5 / 2, 6e-6) << "not measured: by the next fewer";
}

TEST_F(SoftTest, RoomIsAskedForTheGrantedSamples) {
  bool answered = false;
  loop_->handle(CapacityRequested{.scene = kScene,
                                  .tenant = kTenant,
                                  .width = 160,
                                  .height = 96,
                                  .samples = 16,
                                  .answer = [&](const Result<void>& room) { answered = room.has_value(); }},
                now_);
  EXPECT_TRUE(answered);
  EXPECT_EQ(fake_->asked_room.samples, 16u);
}

}  // namespace
}  // namespace gnomon::daemon
