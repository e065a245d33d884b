// When a client gives up datagrams and when it returns to them, in virtual time.
#include "client/net/path_watch.h"

#include <gtest/gtest.h>

namespace gnomon::client {
namespace {

using namespace std::chrono_literals;

struct Path {
  PathWatch watch;
  TimePoint now{1h};
  int pings = 0;

  explicit Path(Transport wanted) : watch(wanted) {}

  // Lets `time` pass. `passes`: each ping is answered before the next is due.
  void live(Nanoseconds time, bool passes) {
    for (const TimePoint end = now + time; now < end; now += PathWatch::kInterval) {
      if (!watch.ping_due(now)) continue;
      ++pings;
      if (passes) watch.heard(now);
    }
  }
};

TEST(PathWatch, StaysWithDatagramsThatPass) {
  Path path(Transport::automatic);
  path.live(1h, true);
  EXPECT_TRUE(path.watch.by_udp());
}

TEST(PathWatch, PingsOnlyWhileNothingComes) {
  Path path(Transport::automatic);
  for (int i = 0; i < 1000; ++i) {
    path.watch.heard(path.now);
    path.live(250ms, false);
  }
  EXPECT_EQ(path.pings, 0);
}

TEST(PathWatch, GivesUpADeadPathAndSoonerOneThatNeverLived) {
  Path dead(Transport::automatic);
  dead.live(1s, false);
  EXPECT_TRUE(dead.watch.by_udp());
  dead.live(500ms, false);
  EXPECT_FALSE(dead.watch.by_udp());

  Path dies(Transport::automatic);
  dies.live(10s, true);
  dies.live(2s, false);
  EXPECT_TRUE(dies.watch.by_udp());
  dies.live(1s, false);
  EXPECT_FALSE(dies.watch.by_udp());
}

TEST(PathWatch, ComesBackWhenDatagramsPassAgain) {
  Path path(Transport::automatic);
  path.live(10s, false);
  ASSERT_FALSE(path.watch.by_udp());
  path.live(1min, true);
  EXPECT_TRUE(path.watch.by_udp());
}

TEST(PathWatch, TriesAPathThatFailedAgainAndAgainLessAndLess) {
  Path path(Transport::automatic);
  std::vector<Nanoseconds> away;
  for (int i = 0; i < 5; ++i) {
    while (path.watch.by_udp()) path.live(250ms, false);
    const TimePoint left = path.now;
    while (!path.watch.by_udp()) path.live(250ms, true);
    away.push_back(path.now - left);
  }
  EXPECT_TRUE(std::is_sorted(away.begin(), away.end()));
  EXPECT_GT(away.back(), 4 * away.front());
}

TEST(PathWatch, DoesAsItIsTold) {
  Path udp(Transport::udp), tcp(Transport::tcp);
  udp.live(1min, false);
  tcp.live(1min, true);
  tcp.watch.heard(tcp.now);
  EXPECT_TRUE(udp.watch.by_udp());
  EXPECT_FALSE(tcp.watch.by_udp());
  EXPECT_EQ(udp.pings + tcp.pings, 0);
}

}  // namespace
}  // namespace gnomon::client
