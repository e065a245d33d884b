#include "daemon/render/share_account.h"

#include <gtest/gtest.h>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
constexpr TenantId kOne{0}, kTwo{1}, kThree{2};
const TimePoint kNow(1h);

class ShareAccountTest : public testing::Test {
 protected:
  void SetUp() override {
    SharingPolicy sharing;
    for (const uint32_t weight : {1u, 3u, 2u}) sharing.tenants.push_back({{.weight = weight}, {}, {}});
    for (uint32_t i = 0; i < 3; ++i) policy_->set_tenant(TenantId{i}, sharing.tenants[i].scheduling);
    account_.set_sharing(sharing);
    account_.report(*policy_);
  }

  std::unique_ptr<scheduler::Scheduler> policy_ = scheduler::make_fair();
  ShareAccount account_;
};

TEST_F(ShareAccountTest, SharesAreOfTheLastWhileAndServiceOfAll) {
  for (int round = 1; round <= 2; ++round) {
    account_.finished(kOne, 1ms, 2ms, kNow);
    account_.finished(kTwo, 6ms, 6ms, kNow);
    const ShareReport report = account_.report(*policy_);
    EXPECT_DOUBLE_EQ(report.tenants[0].share, 0.25);
    EXPECT_DOUBLE_EQ(report.tenants[1].share, 0.75);
    EXPECT_DOUBLE_EQ(report.tenants[2].share, 0);
    EXPECT_EQ(report.tenants[0].service, Nanoseconds(round * 2ms));
    EXPECT_DOUBLE_EQ(report.tenants[0].predicted_error, 0.5);
    EXPECT_DOUBLE_EQ(report.tenants[1].predicted_error, 0);
  }
}

TEST_F(ShareAccountTest, OnlyWhoAlwaysHadWorkIsCompared) {
  account_.queued(kOne);
  account_.queued(kTwo);
  account_.report(*policy_);
  account_.sample_backlog();
  account_.finished(kOne, 2ms, 2ms, kNow);
  account_.finished(kTwo, 6ms, 6ms, kNow);
  account_.finished(kThree, 50ms, 50ms, kNow);  // this tenant did not always have work
  ShareReport report = account_.report(*policy_);
  EXPECT_DOUBLE_EQ(report.jain, 1);
  EXPECT_DOUBLE_EQ(report.tenants[0].expected_share, 0.25);
  EXPECT_DOUBLE_EQ(report.tenants[1].expected_share, 0.75);
  EXPECT_DOUBLE_EQ(report.tenants[2].expected_share, 0);

  account_.sample_backlog();
  account_.finished(kOne, 2ms, 2ms, kNow);
  report = account_.report(*policy_);
  EXPECT_DOUBLE_EQ(report.jain, 0.5) << "one of two got everything";
}

TEST_F(ShareAccountTest, WhatWasSpentStaysSpentWhenTheConfigurationIsReadAgain) {
  SharingPolicy sharing;
  sharing.tenants.push_back({{.weight = 1}, {.buffers_per_second = 10}, {}});
  account_.set_sharing(sharing);
  for (int frame = 0; frame < 20; ++frame) account_.started(kOne, true, 1, kNow);
  const TimePoint closed_until = account_.eligible_at(kOne);
  EXPECT_GT(closed_until, kNow + 1s);
  account_.set_sharing(sharing);
  EXPECT_EQ(account_.eligible_at(kOne), closed_until);
  sharing.tenants[0].rates.buffers_per_second = 1000;
  account_.set_sharing(sharing);
  EXPECT_LE(account_.eligible_at(kOne), kNow) << "a mistaken limit does not outlive its correction";
}

TEST_F(ShareAccountTest, NobodyIsUnfairlyTreatedAlone) {
  account_.sample_backlog();
  EXPECT_DOUBLE_EQ(account_.report(*policy_).jain, 1);
  EXPECT_EQ(account_.eligible_at(kOne), TimePoint::min()) << "and nothing limits it";
}

}  // namespace
}  // namespace gnomon::daemon
