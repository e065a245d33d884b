// Builds beside the frames: they run one after the other, at low priority, and stop when they are no longer needed.
#include "gpu/scene/light_builds.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <future>

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr SceneId kRoom{1}, kHall{2}, kAttic{3};

// Waits for a result that the owner's thread must finish, and finishes it.
struct Owner {
  Inbox<int> woken;  // outlives the builds, whose thread pushes to it until it has ended
  LightBuilds builds;
  std::function<void()> wake() {
    return [this] { woken.push(0); };
  }
  void finish_one() {
    std::vector<int> batch;
    woken.take(batch);
    builds.finish();
  }
};

TEST(LightBuilds, TellsOfEachLightHowFarItIsAndForgetsItAtTheEnd) {
  Owner owner;
  std::promise<void> half, go_on;
  bool done = false;
  owner.builds.start(
      {kRoom}, 3,
      [&](const BuildWatch& watch) {
        watch.progress(0, 1);
        watch.progress(1, 0.5);
        watch.progress(size_t{1} << 40, 0.5);  // a light that there is not, as a broken worker may say
        half.set_value();
        go_on.get_future().wait();
        return [&] { done = true; };
      },
      owner.wake());
  half.get_future().wait();
  EXPECT_EQ(owner.builds.progress(kRoom).lights, (std::vector<float>{1, 0.5f, 0}));
  EXPECT_TRUE(owner.builds.progress(kHall).lights.empty());
  go_on.set_value();
  owner.finish_one();
  EXPECT_TRUE(done);
  EXPECT_TRUE(owner.builds.progress(kRoom).lights.empty());
}

TEST(LightBuilds, GivesFramesPrecedence) {
  Owner owner;
  int niceness = 0;
  owner.builds.start(
      {kRoom}, 1,
      [&](const BuildWatch&) {
        niceness = getpriority(PRIO_PROCESS, static_cast<id_t>(gettid()));
        return [] {};
      },
      owner.wake());
  owner.finish_one();
  EXPECT_GT(niceness, getpriority(PRIO_PROCESS, static_cast<id_t>(gettid())));
}

// A build that runs until it is stopped, and reports whether it was.
LightBuilds::Work endless(std::promise<void>& begun, bool& stopped) {
  return [&](const BuildWatch& watch) {
    begun.set_value();
    while (!watch.stop.stop_requested()) std::this_thread::yield();
    return [&] { stopped = true; };
  };
}

TEST(LightBuilds, StopsABuildWhoseSceneLeaves) {
  Owner owner;
  std::promise<void> begun;
  bool stopped = false;
  owner.builds.start({kRoom}, 1, endless(begun, stopped), owner.wake());
  begun.get_future().wait();
  owner.builds.stop(kRoom);
  EXPECT_TRUE(owner.builds.progress(kRoom).lights.empty());
  owner.finish_one();
  EXPECT_TRUE(stopped);
}

TEST(LightBuilds, ALaterBuildOfASceneTakesThePlaceOfTheFirst) {
  Owner owner;
  std::promise<void> begun;
  bool stopped = false, built = false;
  owner.builds.start({kRoom}, 1, endless(begun, stopped), owner.wake());
  begun.get_future().wait();
  owner.builds.start(
      {kRoom}, 2, [&](const BuildWatch&) { return [&] { built = true; }; }, owner.wake());
  while (!built) owner.finish_one();
  EXPECT_TRUE(stopped);
  EXPECT_TRUE(owner.builds.progress(kRoom).lights.empty());
}

TEST(LightBuilds, BeginNothingNewWhileTheyAreHeld) {
  Owner owner;
  bool first = false, second = false;
  owner.builds.pause({});
  owner.builds.pause({});
  owner.builds.start(
      {kRoom}, 1, [&](const BuildWatch&) { return [&] { first = true; }; }, owner.wake());
  owner.builds.start(
      {kHall}, 2, [&](const BuildWatch&) { return [&] { second = true; }; }, owner.wake());
  owner.builds.resume({});
  EXPECT_EQ(owner.builds.progress(kHall).lights.size(), 2u) << "it waits for its turn";
  EXPECT_TRUE(owner.woken.push(0));
  owner.finish_one();
  EXPECT_FALSE(first);
  owner.builds.resume({});
  while (!second) owner.finish_one();
  EXPECT_TRUE(first);
}

TEST(LightBuilds, AnotherOwnersScenesWaitForNone) {
  Owner owner;
  const SceneOwner greedy{1}, modest{2};
  std::promise<void> begun;
  bool stopped = false, second = false, other = false;
  owner.builds.start({kRoom, greedy}, 1, endless(begun, stopped), owner.wake());
  begun.get_future().wait();
  owner.builds.start(
      {kAttic, greedy}, 1, [&](const BuildWatch&) { return [&] { second = true; }; }, owner.wake());
  owner.builds.pause(greedy);
  owner.builds.start(
      {kHall, modest}, 1, [&](const BuildWatch&) { return [&] { other = true; }; }, owner.wake());
  owner.finish_one();
  EXPECT_TRUE(other) << "beside a build that never ends";
  EXPECT_FALSE(second) << "one at a time of an owner";
  owner.builds.stop(kRoom);
  while (!second) owner.finish_one();
  EXPECT_TRUE(stopped);
}

TEST(LightBuilds, TheirEndStopsTheBuildUnderWay) {
  std::promise<void> begun;
  bool stopped = false;
  {
    Owner owner;
    owner.builds.start({kRoom}, 1, endless(begun, stopped), owner.wake());
    begun.get_future().wait();
  }
  EXPECT_FALSE(stopped) << "the result of a build without owner is dropped";
}

}  // namespace
}  // namespace gnomon::test
