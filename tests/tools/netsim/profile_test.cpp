#include "tests/tools/netsim/profile.h"

#include <gtest/gtest.h>

namespace gnomon::netsim {
namespace {

using namespace std::chrono_literals;

TEST(Profile, AllPropertiesAreRead) {
  Profile profile;
  const auto done = apply(
      "delay=50ms,jitter=1.5ms,loss=2%,burst=1%:0.3,reorder=3%,reorder_by=20ms,duplicate=0.5%,rate=20mbit,queue="
      "30ms,mtu=1280,udp=off",
      profile);
  ASSERT_TRUE(done) << done.error().message;
  EXPECT_EQ(profile.delay, 50ms);
  EXPECT_EQ(profile.jitter, 1500us);
  EXPECT_DOUBLE_EQ(profile.loss, 0.02);
  EXPECT_DOUBLE_EQ(profile.burst_enter, 0.01);
  EXPECT_DOUBLE_EQ(profile.burst_leave, 0.3);
  EXPECT_DOUBLE_EQ(profile.reorder, 0.03);
  EXPECT_EQ(profile.reorder_by, 20ms);
  EXPECT_DOUBLE_EQ(profile.duplicate, 0.005);
  EXPECT_DOUBLE_EQ(profile.rate_bit_per_s, 20e6);
  EXPECT_EQ(profile.queue, 30ms);
  EXPECT_EQ(profile.mtu, 1280u);
  EXPECT_FALSE(profile.udp);
}

TEST(Profile, AQueueMayBeGivenInBytes) {
  Profile profile;
  ASSERT_TRUE(apply("queue=64kb", profile));
  EXPECT_EQ(profile.queue_bytes, 64000u);
  ASSERT_TRUE(apply("queue=10ms", profile));
  EXPECT_EQ(profile.queue_bytes, 0u);
}

TEST(Profile, WhatIsNotNamedStays) {
  Profile profile;
  profile.loss = 0.5;
  ASSERT_TRUE(apply("delay=1s", profile));
  EXPECT_DOUBLE_EQ(profile.loss, 0.5);
}

TEST(Profile, NonsenseIsNamed) {
  for (const char* text : {"delay=50", "delay=-1ms", "loss=200%", "loss=x", "rate=fast", "burst=1%", "speed=1",
                           "delay", "queue=many", "mtu=-1", "udp=maybe", "rate=infbit", "delay=nanms"}) {
    Profile profile;
    const auto done = apply(text, profile);
    ASSERT_FALSE(done) << text;
    EXPECT_NE(done.error().message.find("such as"), std::string::npos) << done.error().message;
  }
}

}  // namespace
}  // namespace gnomon::netsim
