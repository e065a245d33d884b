// When another job may be submitted to a device.
#include "daemon/render/device_load.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr uint32_t kFree = 8, kInFlight = 6;
constexpr Nanoseconds kQuantum = 4ms;

class DeviceLoadTest : public testing::Test {
 protected:
  void start(Nanoseconds predicted) {
    load_.frame_begun();
    load_.frame_submitted();
    load_.job_started(predicted, now_);
  }
  bool room(uint32_t overlapping) { return load_.look_for_room(kFree, kInFlight, overlapping, kQuantum, now_); }

  DeviceLoad load_;
  TimePoint now_{1h};
};

TEST_F(DeviceLoadTest, ADeviceThatRunsOneJobAtATimeGetsTheNextShortlyBeforeItRunsDry) {
  EXPECT_TRUE(room(1));
  start(1900us);
  EXPECT_FALSE(room(1));
  EXPECT_EQ(load_.room_at(), now_ + 900us);
  now_ += 900us;
  EXPECT_TRUE(room(1));
}

TEST_F(DeviceLoadTest, ADeviceThatRunsSeveralAtATimeGetsSoMany) {
  for (int jobs = 0; jobs < 3; ++jobs) {
    EXPECT_TRUE(room(3)) << jobs;
    start(600us);
  }
  EXPECT_FALSE(room(3));
}

TEST_F(DeviceLoadTest, HalfAQuantumOfWorkIsEnough) {
  start(2100us);
  EXPECT_FALSE(room(3)) << "a newcomer would wait for longer than for a quantum";
  EXPECT_EQ(load_.room_at(), TimePoint::max());
  load_.job_finished(2100us, now_);
  EXPECT_TRUE(room(3));
}

TEST_F(DeviceLoadTest, FramesInFlightAndFreeSlotsAreLimits) {
  for (uint32_t frame = 0; frame < kInFlight; ++frame) start(1us);
  EXPECT_FALSE(room(16));
  load_.slot_freed();
  EXPECT_TRUE(room(16));
  EXPECT_FALSE(load_.look_for_room(0, kInFlight, 16, kQuantum, now_));
}

}  // namespace
}  // namespace gnomon::daemon
