// Frames that cost more than a quantum, and the sessions that wait for them.
#include <algorithm>
#include <random>

#include "tests/unit/daemon/render/render_loop_fixture.h"

namespace gnomon::daemon {
namespace {

// Frames of 16x800 pixels, 100 rows of tiles, that cost 1 us a row.
class CutFrameTest : public RenderLoopTest {
 protected:
  static constexpr uint32_t kHeight = 800;

  void SetUp() override {
    RenderLoopTest::SetUp();
    SharingPolicy sharing = sharing_policy_of({});
    sharing.quantum = Nanoseconds(0);
    loop_->handle(SharingPolicyChanged{sharing}, now_);
    loop_->handle(SessionClosed{kA}, now_);
    loop_->handle(SessionClosed{kB}, now_);
    open(kA, {.width = 16, .height = kHeight});
    open(kB, {.width = 16, .height = kHeight});
    view(kA, 1);  // the model learns what a frame costs
    settle();
    fake_->complete(100us);
    rendered_.clear();
    settle();
    sharing.quantum = 75us;
    loop_->handle(SharingPolicyChanged{sharing}, now_);
  }

  void complete_one() { fake_->complete(fake_->rows(0) * 1us); }

  // Completes what is on the device, each band at its cost, and starts what follows. Returns the number of submits.
  size_t run_to_the_end() {
    size_t submits = 0;
    for (settle(); fake_->waiting() > 0; settle(), ++submits) complete_one();
    return submits;
  }
};

// The configuration leaves the quantum to the daemon. A frame costs 20 ms, 200 us a row.
class UsualQuantumTest : public CutFrameTest, public testing::WithParamInterface<bool> {
 protected:
  void SetUp() override {
    cpu_ = GetParam();
    CutFrameTest::SetUp();
    loop_->handle(SharingPolicyChanged{sharing_policy_of({})}, now_);
  }
  size_t pieces_of_a_frame(uint32_t frame) {
    view(kA, frame);
    size_t submits = 0;
    for (settle(); fake_->waiting() > 0; settle(), ++submits) fake_->complete(fake_->rows(0) * 200us);
    rendered_.clear();  // frees the slot
    settle();
    return submits;
  }
};

TEST_P(UsualQuantumTest, OnACpuFramesAreCutLater) {
  uint32_t frame = 100;
  for (int i = 0; i < 40; ++i) pieces_of_a_frame(frame++);  // the model learns the cost
  const size_t pieces = pieces_of_a_frame(frame);
  if (GetParam()) {
    EXPECT_EQ(pieces, 1u) << "less than half of 100 ms";
  } else {
    EXPECT_GE(pieces, 15u) << "each at most a third of 4 ms";
  }
}
INSTANTIATE_TEST_SUITE_P(Kinds, UsualQuantumTest, testing::Bool(),
                         [](const auto& instance) { return instance.param ? "Cpu" : "Gpu"; });

// What it costs is not known, and may be anything.
TEST_F(RenderLoopTest, TheFirstFrameOfASceneBeginsWithARow) {
  loop_->handle(SessionClosed{kA}, now_);
  open(kA, {.width = 160, .height = 800});
  view(kA, 1);
  settle();
  EXPECT_LE(fake_->waiting(), 3u) << "a quantum's worth";
  std::vector<uint32_t> pieces;
  for (; fake_->waiting() > 0; settle()) {
    pieces.push_back(fake_->rows(0));
    fake_->complete(fake_->rows(0) * 1us);
  }
  EXPECT_EQ(pieces.front(), 1u);
  EXPECT_LE(pieces.size(), 6u) << "the rest is cheap";
  EXPECT_EQ(rendered_frames_of(kA), std::vector<uint32_t>{1});
}

TEST_F(CutFrameTest, AFrameThatCostsMoreIsCutAndAnsweredAsOne) {
  view(kA, 2);
  EXPECT_EQ(run_to_the_end(), 5u) << "100 us in pieces of at most a third of a quantum";
  ASSERT_EQ(rendered_.size(), 1u);
  EXPECT_EQ(rendered_[0].meta.times.gpu, Nanoseconds(100us));
  EXPECT_EQ(rendered_[0].mask.mask().grid.height, kHeight);
}

// Views of the sky make the model say that a frame costs next to nothing.
TEST_F(CutFrameTest, AViewThatWasCheapIsCutByWhatTheDearestCost) {
  constexpr auto kDearRow = 30us;
  uint32_t frame = 2, most_rows = 0;
  const auto show = [&](Nanoseconds row) {
    view(kA, frame++);
    most_rows = 0;
    for (settle(); fake_->waiting() > 0; settle()) {
      most_rows = std::max(most_rows, fake_->rows(0));
      fake_->complete(fake_->rows(0) * row);
    }
    rendered_.clear();
  };
  for (int i = 0; i < 3; ++i) show(kDearRow);
  for (int i = 0; i < 200; ++i) show(10ns);
  show(kDearRow);
  EXPECT_LE(most_rows * kDearRow, 75us) << "a quantum";
}

TEST_F(CutFrameTest, ABandThatCouldNotBeStartedCostsItsFrameAlone) {
  view(kA, 2);
  settle();
  view(kA, 3);
  fake_->refuse_to_start();
  run_to_the_end();
  EXPECT_EQ(rendered_frames_of(kA), std::vector<uint32_t>{3});
  EXPECT_EQ(metrics_.count_of(Fault::submit_failed), 1u);
  rendered_.clear();
  settle();
  EXPECT_EQ(fake_->begun(), 0u);
  EXPECT_EQ(fake_->free_slots(), slots_);
  EXPECT_EQ(loop_->frames_out(), 0u);
}

TEST_F(CutFrameTest, TheLastBandThatCouldNotBeStartedCostsItsFrameOnce) {
  view(kA, 2);
  settle();
  for (uint32_t rows = 0; rows + fake_->rows(0) < kHeight / 8; settle()) {
    rows += fake_->rows(0);
    complete_one();
  }
  fake_->refuse_to_start();
  settle();
  EXPECT_TRUE(rendered_.empty());
  EXPECT_EQ(metrics_.count_of(Fault::submit_failed), 1u);
  EXPECT_EQ(fake_->free_slots(), slots_);
  EXPECT_EQ(loop_->frames_out(), 0u);
}

TEST_F(CutFrameTest, TheNextJobFollowsWhenTheDeviceIsAboutToRunDry) {
  view(kA, 2);
  loop_->start(now_);
  EXPECT_EQ(fake_->waiting(), 1u) << "20 us of work";
  EXPECT_EQ(loop_->wake_at(), now_ + Nanoseconds(1250)) << "a quarter of the quantum before";
  now_ = loop_->wake_at();
  loop_->start(now_);
  EXPECT_EQ(fake_->waiting(), 2u);
  now_ += 1s;
  settle();
  EXPECT_EQ(fake_->waiting(), 2u) << "late as it is, no third one";
  EXPECT_EQ(run_to_the_end(), 5u);
}

TEST_F(CutFrameTest, RasterisingThatCostsMoreThanAPieceStandsAlone) {
  for (uint32_t frame = 2; frame < 60; ++frame) {
    view(kA, frame);
    for (settle(); fake_->waiting() > 0; settle()) {
      fake_->complete(fake_->begins(0) ? 200us : fake_->rows(0) * 1us, false, fake_->rows(0) * 1us);
    }
    rendered_.clear();
  }
  view(kA, 60);
  settle();
  ASSERT_EQ(fake_->waiting(), 1u);
  EXPECT_EQ(fake_->rows(0), 0u);
  run_to_the_end();
  EXPECT_EQ(rendered_frames_of(kA), std::vector<uint32_t>{60});
}

TEST_F(CutFrameTest, OthersPassBetweenBands) {
  view(kA, 2);
  settle();
  open(SessionId{44}, {.width = 8, .height = 8});
  SharingPolicy two = sharing_policy_of({});
  two.quantum = 75us;
  two.tenants.push_back({});
  loop_->handle(SharingPolicyChanged{two}, now_);
  open(SessionId{55}, {.tenant = TenantId{1}, .width = 8, .height = 8});
  view(SessionId{55}, 1);
  while (rendered_.empty() && fake_->waiting() > 0) {
    complete_one();
    settle();
  }
  ASSERT_EQ(rendered_.size(), 1u);
  EXPECT_EQ(rendered_[0].meta.route.session, SessionId{55});
}

TEST_F(CutFrameTest, ANewerViewWaitsForTheFrameThatWasBegun) {
  view(kA, 2);
  settle();
  view(kA, 3);
  run_to_the_end();
  EXPECT_EQ(rendered_frames_of(kA), (std::vector<uint32_t>{2, 3}));
}

TEST_F(CutFrameTest, ASessionThatClosesGivesItsBegunFrameUp) {
  view(kA, 2);
  settle();
  EXPECT_EQ(fake_->begun(), 1u);
  loop_->handle(SessionClosed{kA}, now_);
  EXPECT_EQ(fake_->begun(), 0u);
  run_to_the_end();
  EXPECT_TRUE(rendered_.empty());
  view(kB, 1);
  run_to_the_end();
  EXPECT_EQ(rendered_frames_of(kB), std::vector<uint32_t>{1});
}

TEST_F(CutFrameTest, ADeviceThatIsLostTakesBegunFramesWithIt) {
  view(kA, 2);
  settle();
  view(kA, 3);
  while (renderers_made_ == 1) {  // another band may have been submitted before the loss was noticed
    fake_->complete(25us, true);
    settle();
  }
  run_to_the_end();
  EXPECT_EQ(rendered_frames_of(kA), std::vector<uint32_t>{3});
}

TEST_F(CutFrameTest, TheLastFreeSlotIsForFramesThatAreDoneAtOnce) {
  SharingPolicy both = sharing_policy_of({});
  both.quantum = 75us;
  both.policy = "deadline";
  loop_->handle(SharingPolicyChanged{both}, now_);
  view(kA, 2);
  settle();
  EXPECT_EQ(fake_->begun(), 1u);
  run_to_the_end();
  rendered_.clear();
  view(kA, 3);
  view(kB, 3);
  settle();
  EXPECT_EQ(fake_->begun(), 1u) << "there are two slots";
  run_to_the_end();
  EXPECT_EQ(rendered_frames_of(kA), std::vector<uint32_t>{3});
  EXPECT_EQ(rendered_frames_of(kB), std::vector<uint32_t>{3});
}

// A device of one queue in virtual time, on which one tenant floods with large frames beside another's small ones.
class NeighbourTest : public RenderLoopTest {
 protected:
  static constexpr Nanoseconds kQuantum = 21ms;
  static constexpr SessionId kSteady{500};
  static constexpr uint32_t kFlood = 32, kInFlight = 3;

  void SetUp() override {
    slots_ = kInFlight + 2;  // each tenant may have one frame in bands
    RenderLoopTest::SetUp();
    for (const SessionId session : {kA, kB, kSilent}) loop_->handle(SessionClosed{session}, now_);
  }

  void begin(const std::string& policy, uint32_t steady_priority) {
    SharingPolicy sharing;
    sharing.policy = policy;
    sharing.quantum = kQuantum;
    sharing.frames_in_flight = kInFlight;
    sharing.tenants.resize(2);
    sharing.tenants[1].scheduling.priority = steady_priority;
    loop_->handle(SharingPolicyChanged{sharing}, now_);
    open(kSteady, {.tenant = TenantId{1}, .width = 160, .height = 96, .lights = 3});
    for (uint32_t i = 0; i < kFlood; ++i) open(SessionId{i}, {.width = 640, .height = 360, .lights = 3});
  }

  // 5 ms and 30 ns a pixel to rasterise, 25 ns a bit to trace, within 10%.
  Nanoseconds next_cost(Nanoseconds& trace) {
    const gpu::RenderJob job = fake_->job(0);
    const double noise = 0.9 + 0.2 * static_cast<double>(random_()) / static_cast<double>(random_.max());
    const double raster = fake_->begins(0) ? 5e6 + 30.0 * job.width * job.height : 0;
    trace = Nanoseconds(static_cast<int64_t>(noise * 25 * 3 * 8 * job.width * fake_->rows(0)));
    return trace + Nanoseconds(static_cast<int64_t>(noise * raster));
  }

  void run(Nanoseconds time) {
    const TimePoint end = now_ + time;
    TimePoint next_steady = now_, done_at = TimePoint::max();
    Nanoseconds cost{}, trace{}, own{};
    TimePoint asked{};
    while (now_ < end) {
      react();
      if (done_at == TimePoint::max() && fake_->waiting() > 0) {
        cost = next_cost(trace);
        done_at = now_ + cost;
      }
      now_ = std::max(now_, std::min({done_at, next_steady, loop_->wake_at()}));
      if (now_ >= done_at) {
        if (fake_->job(0).width == 160) own += cost;
        fake_->complete(cost, false, trace);
        done_at = TimePoint::max();
      }
      if (now_ >= next_steady) {
        view(kSteady, ++frame_);
        asked = now_;
        own = {};
        next_steady = now_ + 60ms + Nanoseconds(random_() % 20'000'000);
      }
      for (RenderedFrame& frame : rendered_) {
        if (frame.meta.route.session == kSteady) waits_.push_back(now_ - asked - own);
        if (frame.meta.route.session != kSteady) view(frame.meta.route.session, ++frame_);
      }
      rendered_.clear();
    }
  }

  void react() {
    std::vector<RenderEvent> batch;
    do {
      inbox_.take(batch, TimePoint::min());
      for (RenderEvent& event : batch) loop_->handle(std::move(event), now_);
    } while (!batch.empty());
    loop_->start(now_);
  }

  std::mt19937 random_{7};
  uint32_t frame_ = 0;
  std::vector<Nanoseconds> waits_;  // of the steady client's frames, without their own time on the device
};

TEST_F(NeighbourTest, AFloodCostsASteadyClientNoMoreThanASlice) {
  for (const auto& [policy, priority] :
       {std::pair("fair", 0), std::pair("priority", 1), std::pair("priority", 0)}) {
    begin(policy, priority);
    run(1s);
    for (uint32_t i = 0; i < kFlood; ++i) view(SessionId{i}, ++frame_);
    run(2s);  // the costs are learned meanwhile
    waits_.clear();
    run(60s);
    EXPECT_GT(waits_.size(), 800u) << policy;
    EXPECT_LE(*std::max_element(waits_.begin(), waits_.end()), kQuantum) << policy << " " << priority;
    for (uint32_t i = 0; i < kFlood; ++i) loop_->handle(SessionClosed{SessionId{i}}, now_);
    loop_->handle(SessionClosed{kSteady}, now_);
    while (fake_->waiting() > 0) fake_->complete();
    rendered_.clear();
    react();
  }
}

}  // namespace
}  // namespace gnomon::daemon
