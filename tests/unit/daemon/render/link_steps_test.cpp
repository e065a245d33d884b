// How a session is degraded when its link is too slow.
#include "daemon/render/link_steps.h"

#include "tests/unit/daemon/render/render_loop_fixture.h"

namespace gnomon::daemon {
namespace {

class NarrowLink : public RenderLoopTest {
 protected:
  static constexpr SessionId kFar{77};

  void SetUp() override {
    RenderLoopTest::SetUp();
    SharingPolicy limits = sharing_policy_of({});
    limits.tenants[0].degradation = {.least_rate = 0.5, .least_size = 0.5};
    loop_->handle(SharingPolicyChanged{limits}, now_);
    open_far();
  }

  void open_far() {
    open(kFar, {.width = 160,
                .height = 96,
                .codec = protocol::CodecId::raw32_lz4,
                .dense_codec = protocol::CodecId::tiles_lz4,
                .features = protocol::kFeatureSizes});
  }

  // Reviews a second in which the link had room for so many of 40 views; then renders one frame.
  void second(uint32_t taken) {
    loop_->handle(LinkReviewed{kFar, {40, taken}}, now_);
    view(kFar, ++frame_);
    settle();
    while (fake_->waiting() > 0) {
      last_ = fake_->job(0);
      fake_->complete();
    }
    settle();
    codec_ = rendered_.back().meta.spec.codec;
    tells_size_ = rendered_.back().meta.spec.tells_size;
    rendered_.clear();
    now_ += 1s;
  }

  uint32_t frame_ = 0;
  gpu::RenderJob last_;
  protocol::CodecId codec_{};
  bool tells_size_ = false;
};

TEST_F(NarrowLink, FewerFramesAreNoReasonDownToTheTenantsLeastRate) {
  for (int i = 0; i < 20; ++i) second(20);
  EXPECT_EQ(codec_, protocol::CodecId::raw32_lz4);
  EXPECT_TRUE(degraded_.empty());
}

TEST_F(NarrowLink, TheCodecGetsDenserThenThePictureSmallerAndBothComeBack) {
  second(5);
  second(5);
  EXPECT_EQ(codec_, protocol::CodecId::tiles_lz4);
  EXPECT_EQ(last_.width, 160u);
  EXPECT_FALSE(tells_size_);
  EXPECT_TRUE(degraded_.empty()) << "slices say which codec they have";
  for (int i = 0; i < 20; ++i) second(5);
  EXPECT_LT(last_.width, 160u);
  EXPECT_GE(last_.width, 80u);
  EXPECT_TRUE(tells_size_);
  ASSERT_FALSE(degraded_.empty());
  EXPECT_EQ(degraded_.back().message.width, last_.width);
  EXPECT_EQ(degraded_.back().message.reason, "the link cannot carry more");
  for (int i = 0; i < 200; ++i) second(40);
  EXPECT_EQ(last_.width, 160u);
  EXPECT_FALSE(tells_size_);
  EXPECT_EQ(codec_, protocol::CodecId::raw32_lz4);
}

TEST_F(NarrowLink, AReviewOfASessionThatIsGoneIsNoStep) {
  second(5);  // another second like it would cause a step
  loop_->handle(SessionClosed{kFar}, now_);
  loop_->handle(LinkReviewed{kFar, {40, 5}}, now_);
  EXPECT_NE(metrics_.text().find("gnomon_degradations_total{direction=\"down\"} 0"), std::string::npos);
  open_far();
  second(5);
  EXPECT_EQ(codec_, protocol::CodecId::raw32_lz4) << "who comes by that number later begins anew";
  EXPECT_TRUE(degraded_.empty());
}

}  // namespace
}  // namespace gnomon::daemon
