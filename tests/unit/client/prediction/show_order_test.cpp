// Which camera is shown with whose masks, by mode (dissertation 2.3, 3.2, 3.3); and when a lost server is tried again.
#include "client/prediction/show_order.h"

#include <gtest/gtest.h>

#include "client/net/reconnect.h"

namespace gnomon::client {
namespace {

using namespace std::chrono_literals;

constexpr Nanoseconds kFrame = 10ms;

// Cameras at a steady rate, whose masks arrive `latency` frames later.
struct Playing {
  ShowOrder order;
  uint32_t latency;
  TimePoint now{};

  Playing(Mode mode, size_t ahead, uint32_t frames)
      : order(mode, std::make_unique<FixedPrediction>(ahead)), latency(frames) {}

  std::optional<Shown> frame() {
    order.asked({}, now);
    const uint32_t n = order.asked_count() - 1;
    if (n >= latency) order.answered(n - latency, now);
    const auto shown = order.next(now);
    now += kFrame;
    return shown;
  }
  Shown settled() {
    std::optional<Shown> shown;
    for (int i = 0; i < 100; ++i) shown = frame();
    return shown.value();
  }
};

TEST(ShowOrder, AServerThatStopsAnsweringCostsNoMemoryForEver) {
  ShowOrder order(Mode::predicted, std::make_unique<FixedPrediction>(4));
  order.asked({}, TimePoint{});
  ASSERT_TRUE(order.answered(0, TimePoint{}));
  ASSERT_TRUE(order.next(TimePoint{}));
  for (int i = 0; i < 4096; ++i) order.asked({}, TimePoint{});
  EXPECT_FALSE(order.next(TimePoint{})) << "the masks are too old to keep their camera";
  ASSERT_TRUE(order.answered(4000, TimePoint{}));
  EXPECT_EQ(order.next(TimePoint{})->seen.index, 4000u);
}

TEST(ShowOrder, ModesShowWhatTheDissertationSays) {
  constexpr uint32_t n = 99, p = 10;
  for (const Mode mode : {Mode::sequential, Mode::queued}) {
    const Shown shown = Playing(mode, 4, p).settled();
    EXPECT_EQ(shown.camera.index, n - p);
    EXPECT_EQ(shown.seen.index, n - p);
    EXPECT_FALSE(shown.reprojected);
  }
  const Shown misaligned = Playing(Mode::non_sequential, 4, p).settled();
  EXPECT_EQ(misaligned.camera.index, n);
  EXPECT_EQ(misaligned.seen.index, n - p);
  EXPECT_FALSE(misaligned.reprojected);
  for (const uint32_t x : {0u, 1u, 4u, 10u, 15u}) {
    Playing run(Mode::predicted, x, p);
    const Shown shown = run.settled();
    EXPECT_EQ(shown.camera.index, n - p + std::min(x, p));
    EXPECT_EQ(shown.seen.index, n - p);
    EXPECT_EQ(shown.ahead(), std::min(x, p));
    EXPECT_EQ(shown.reprojected, x > 0);
    // Each frame predicted takes one frame off the response time.
    EXPECT_EQ(run.now - kFrame - shown.camera.asked, (p - std::min(x, p)) * kFrame);
  }
}

TEST(ShowOrder, NothingBeforeMasksAndNothingTwice) {
  ShowOrder order(Mode::predicted, std::make_unique<FixedPrediction>(2));
  EXPECT_FALSE(order.next({}));
  order.asked({}, {});
  EXPECT_FALSE(order.next({}));
  EXPECT_FALSE(order.answered(7, {})) << "never asked for";
  EXPECT_TRUE(order.answered(0, {}));
  EXPECT_FALSE(order.answered(0, {}));
  EXPECT_TRUE(order.next({}));
  EXPECT_FALSE(order.next({}));
}

TEST(ShowOrder, PicturesNeverGoBack) {
  Playing run(Mode::predicted, 8, 10);
  run.settled();
  uint32_t last = 0;
  // The link becomes slow, then fast; some answers are lost or overtaken.
  for (int i = 0; i < 200; ++i) {
    run.latency = i < 60 ? 10 : i < 120 ? 18 : 2;
    if (i % 7 == 3) run.order.answered(run.order.asked_count() / 2, run.now);
    const auto shown = run.frame();
    if (!shown) continue;
    EXPECT_GE(shown->camera.index, last);
    EXPECT_GE(shown->camera.index, shown->seen.index);
    EXPECT_LE(shown->ahead(), kMostAhead);
    last = shown->camera.index;
  }
}

TEST(ShowOrder, ASilentServerStopsThePictureAtTheMostThatIsPredicted) {
  Playing run(Mode::predicted, kMostAhead, 5);
  const Shown before = run.settled();
  run.latency = 1'000'000;
  std::optional<Shown> last;
  for (int i = 0; i < 100; ++i)
    if (const auto shown = run.frame()) last = shown;
  ASSERT_TRUE(last);
  EXPECT_EQ(last->seen.index, before.seen.index);
  EXPECT_EQ(last->ahead(), kMostAhead);
}

TEST(Reconnect, WaitsLongerEachTimeUntilItSucceeds) {
  Reconnect reconnect;
  EXPECT_EQ(reconnect.wait_after({}), Reconnect::kFirst);
  EXPECT_EQ(reconnect.wait_after({}), 2 * Reconnect::kFirst);
  for (int i = 0; i < 20; ++i) EXPECT_LE(*reconnect.wait_after({}), Reconnect::kLongest);
  reconnect.connected();
  EXPECT_EQ(reconnect.wait_after({}), Reconnect::kFirst);
}

TEST(Reconnect, DoesNotInsistWhereItIsNotWanted) {
  const auto after = [](protocol::RefusalCode code) {
    protocol::Refused refused;
    refused.code = code;
    return Reconnect().wait_after(refused).has_value();
  };
  EXPECT_TRUE(after(protocol::RefusalCode::draining));
  EXPECT_TRUE(after(protocol::RefusalCode::over_capacity));
  EXPECT_FALSE(after(protocol::RefusalCode::bad_token));
  EXPECT_FALSE(after(protocol::RefusalCode::unknown_scene));
  EXPECT_FALSE(after(protocol::RefusalCode::kept_out));
}

}  // namespace
}  // namespace gnomon::client
