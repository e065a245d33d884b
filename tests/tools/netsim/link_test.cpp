#include "tests/tools/netsim/link.h"

#include <gtest/gtest.h>

#include <map>

namespace gnomon::netsim {
namespace {

using namespace std::chrono_literals;

constexpr TimePoint kStart{};
constexpr int kMany = 20000;

Profile profile_of(std::string_view text) {
  Profile profile;
  const auto done = apply(text, profile);
  EXPECT_TRUE(done) << done.error().message;
  return profile;
}

Link link_of(std::string_view text, uint64_t seed = 1) { return Link({{0s, profile_of(text)}}, seed, kStart); }

std::vector<Fate> send_many(Link& link, int count = kMany, size_t bytes = 1000, Nanoseconds apart = 1ms) {
  std::vector<Fate> fates;
  for (int i = 0; i < count; ++i) fates.push_back(link.send(bytes, kStart + i * apart));
  return fates;
}

double share_of(const std::vector<Fate>& fates, Fate::Kind kind) {
  const auto count = std::count_if(fates.begin(), fates.end(), [&](const Fate& f) { return f.kind == kind; });
  return static_cast<double>(count) / static_cast<double>(fates.size());
}

TEST(Link, APerfectOneOnlyDelays) {
  Link link = link_of("delay=50ms");
  for (const Fate& fate : send_many(link, 10)) ASSERT_EQ(fate.copies, 1u);
  EXPECT_EQ(link.send(1000, kStart + 1s).at[0], kStart + 1050ms);
}

TEST(Link, TheSameSeedHasTheSameLuckAndAnotherHasNot) {
  const std::string_view bad = "delay=10ms,jitter=5ms,loss=10%,burst=1%:20%,reorder=5%,duplicate=5%,rate=20mbit";
  Link one = link_of(bad, 7), two = link_of(bad, 7), other = link_of(bad, 8);
  const auto first = send_many(one), second = send_many(two), third = send_many(other);
  size_t differ = 0;
  for (size_t i = 0; i < first.size(); ++i) {
    ASSERT_EQ(first[i].at, second[i].at) << i;
    ASSERT_EQ(first[i].kind, second[i].kind) << i;
    differ += first[i].at != third[i].at;
  }
  EXPECT_GT(differ, first.size() / 2);
}

TEST(Link, BlocksDatagramsThatAreTooLongAndNothingElse) {
  Link link({{0s, profile_of("mtu=1280")}, {1s, profile_of("udp=off")}}, 1, kStart);
  EXPECT_EQ(link.send_datagram(1280, kStart).kind, Fate::Kind::arrives);
  EXPECT_EQ(link.send_datagram(1281, kStart).kind, Fate::Kind::blocked);
  EXPECT_EQ(link.send(1400, kStart).kind, Fate::Kind::arrives) << "connections cut theirs to fit";
  EXPECT_EQ(link.send_datagram(10, kStart + 1s).copies, 0u);
  EXPECT_EQ(link.send(10, kStart + 1s).copies, 1u);
}

TEST(Link, LosesTheShareThatItShould) {
  Link link = link_of("loss=5%");
  EXPECT_NEAR(share_of(send_many(link), Fate::Kind::lost), 0.05, 0.01);
}

// Gilbert's model: in the long run enter / (enter + leave) of the packets are lost, in runs of 1 / leave on average.
TEST(Link, BurstsHaveTheirShareAndLength) {
  Link link = link_of("burst=1%:25%");
  const auto fates = send_many(link, 10 * kMany);
  int runs = 0, lost = 0;
  for (size_t i = 1; i < fates.size(); ++i) {
    lost += fates[i].copies == 0;
    runs += fates[i].copies == 0 && fates[i - 1].copies == 1;
  }
  EXPECT_NEAR(static_cast<double>(lost) / (10.0 * kMany), 0.01 / 0.26, 0.005);
  EXPECT_NEAR(static_cast<double>(lost) / runs, 4.0, 0.4);
}

TEST(Link, DuplicatesArriveTwice) {
  Link link = link_of("duplicate=10%");
  int twice = 0;
  for (const Fate& fate : send_many(link)) twice += fate.copies == 2;
  EXPECT_NEAR(twice / static_cast<double>(kMany), 0.1, 0.01);
}

TEST(Link, JitterKeepsTheOrderAndReorderingBreaksIt) {
  const auto overtaken = [](Link link) {
    int count = 0;
    TimePoint newest = kStart;
    for (const Fate& fate : send_many(link)) {
      count += fate.at[0] < newest;
      newest = std::max(newest, fate.at[0]);
    }
    return count;
  };
  EXPECT_EQ(overtaken(link_of("delay=20ms,jitter=10ms")), 0);
  EXPECT_GT(overtaken(link_of("delay=20ms,reorder=2%,reorder_by=5ms")), kMany / 50);
}

TEST(Link, JitterStaysWithinItsBounds) {
  Link link = link_of("delay=20ms,jitter=4ms");
  TimePoint sent = kStart;
  for (const Fate& fate : send_many(link, 1000, 1000, 100ms)) {
    EXPECT_GE(fate.at[0] - sent, 16ms);
    EXPECT_LE(fate.at[0] - sent, 24ms);
    sent += 100ms;
  }
}

TEST(Link, TheRateIsTheBottlenecks) {
  Link link = link_of("rate=8mbit,queue=10s");
  // 1,000 bytes take 1 ms: ten sent at once leave one after the other.
  for (int i = 0; i < 10; ++i) EXPECT_EQ(link.send(1000, kStart).at[0], kStart + (i + 1) * 1ms);
  EXPECT_EQ(link.backlog(kStart), 10ms);
  EXPECT_EQ(link.backlog(kStart + 4ms), 6ms);
  EXPECT_EQ(link.send(1000, kStart + 20ms).queued, 0ms);
}

TEST(Link, AFullQueueDrops) {
  Link by_time = link_of("rate=8mbit,queue=5ms"), by_bytes = link_of("rate=8mbit,queue=6kb");
  EXPECT_EQ(share_of(send_many(by_time, 10, 1000, 0ms), Fate::Kind::queue_full), 0.4);
  EXPECT_EQ(share_of(send_many(by_bytes, 10, 1000, 0ms), Fate::Kind::queue_full), 0.4);
}

TEST(Link, PhasesFollowEachOther) {
  Link link(
      {{0s, profile_of("delay=1ms")}, {5s, profile_of("delay=2ms,loss=100%")}, {10s, profile_of("delay=3ms")}}, 1,
      kStart);
  EXPECT_EQ(link.send(100, kStart + 4999ms).at[0], kStart + 5000ms);
  EXPECT_EQ(link.send(100, kStart + 5s).copies, 0u);
  EXPECT_EQ(link.send(100, kStart + 10s).at[0], kStart + 10003ms);
}

}  // namespace
}  // namespace gnomon::netsim
