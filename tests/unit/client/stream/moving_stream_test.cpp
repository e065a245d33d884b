// A stream whose server drains: another session takes its place, and what the engine sees goes on.
#include "client/stream/moving_stream.h"

#include <gtest/gtest.h>

#include <atomic>

#include "tests/unit/client/net/fake_server.h"
#include "tests/unit/client/stream/watched.h"
#include "tests/unit/protocol/masks.h"

namespace gnomon::client {
namespace {

using namespace tests;
using namespace std::chrono_literals;

constexpr protocol::Draining kGoNow{0, protocol::Draining::kMoveNow};  // at once
constexpr auto kTurns = FakeServer::Turns::at_once;

// Asks for a camera every few milliseconds, and keeps what it is told.
struct Mover {
  struct Answered {
    uint32_t index;
    float x;
    std::vector<uint64_t> words;
  };

  Loop loop;
  std::vector<Answered> answers;
  std::vector<protocol::Message> messages;
  std::optional<Error> closed;
  uint32_t asked = 0;
  int moves = 0;
  MovingStream stream;

  explicit Mover(const Address& door)
      : stream(loop, options_for(door),
               {.answer =
                    [this](const Answer& a) {
                      answers.push_back({a.index, a.camera.position[0], a.mask.words});
                    },
                .moved = [this] { ++moves; },
                .message = [this](const protocol::Message& m) { messages.push_back(m); },
                .closed = [this](const Error& error) { closed = error; }}) {}

  template <class Done>
  bool fly_until(Done done) {
    const TimePoint end = Clock::now() + 20s;
    while (!done()) {
      if (Clock::now() > end) return false;
      if (stream.connection().state() == Connection::State::open) {
        stream.ask(camera_at(static_cast<float>(asked)), {}, asked);
        ++asked;
      }
      loop.run_until(Clock::now() + 5ms, [] { return false; });
    }
    return true;
  }

  template <class M>
  size_t told() const {
    return static_cast<size_t>(std::count_if(messages.begin(), messages.end(),
                                             [](const auto& m) { return std::holds_alternative<M>(m); }));
  }

  void expect_order() const {
    for (size_t i = 0; i < answers.size(); ++i) {
      EXPECT_EQ(answers[i].x, static_cast<float>(answers[i].index)) << "an answer is of its camera";
      if (i == 0) continue;
      EXPECT_GT(answers[i].index, answers[i - 1].index) << "answers never go back";
    }
  }
};

const Mask kOld = noise(kGrid, 1), kNew = noise(kGrid, 2);

void open(Peer& peer, protocol::Welcome welcome = small_welcome(kWidth, kHeight, kLights)) {
  EXPECT_TRUE(peer.read());
  peer.welcome(std::move(welcome));
}

// False if no camera comes.
bool answer_one(Peer& peer, const Mask& mask) {
  const auto camera = peer.read_new_camera();
  if (camera) peer.send_frame(camera->frame, mask.view());
  return camera.has_value();
}

// Answers the first camera that the mover asks for after `turns` more turns of its loop: until then it has read what was
// written to it before, which comes by another socket and so in no order with the answer.
void answer_one_after(Peer& peer, int turns, const Mask& mask) {
  std::optional<float> first;
  while (const auto camera = peer.read_new_camera()) {
    if (!first) first = camera->camera.position[0];
    if (camera->camera.position[0] < *first + static_cast<float>(turns)) continue;
    return peer.send_frame(camera->frame, mask.view());
  }
}

// The reason of the Bye that comes; "" if none does.
std::string read_bye(Peer& peer) {
  while (const auto message = peer.read()) {
    if (const auto* bye = std::get_if<protocol::Bye>(&*message)) return bye->reason;
  }
  return "";
}

TEST(MovingStream, TheFirstWholeFrameOfTheNewSessionEndsTheOldOne) {
  std::atomic<int> connections = 0, old_answers = 0;
  std::atomic<bool> answered = false, seen = false;
  std::string bye;
  {
    FakeServer fleet(
        [&](Peer& peer) {
          if (++connections == 1) {
            open(peer);
            answer_one(peer, kOld);
            peer.write(kGoNow);
            for (; !answered && answer_one(peer, kOld);) ++old_answers;
            bye = read_bye(peer);
          } else {
            open(peer);
            const int before = old_answers;
            while (old_answers < before + 5) std::this_thread::sleep_for(1ms);
            answer_one(peer, kNew);
            answered = true;
            // Cameras that were waiting meanwhile may be older than what the old session answered.
            while (!seen && answer_one(peer, kNew)) {
            }
            read_bye(peer);
          }
        },
        2, FakeServer::usual_identity(), kTurns);
    Mover mover(fleet.address());
    ASSERT_TRUE(mover.stream.wait_open());
    EXPECT_TRUE(mover.fly_until([&] { return mover.moves == 1 && mover.answers.back().words == kNew.words; }));
    seen = true;
    EXPECT_FALSE(mover.stream.is_moving());
    EXPECT_GE(mover.answers.size(), 7u) << "the old session is asked until then";
    mover.expect_order();
    EXPECT_EQ(mover.stream.counters().moved, 1u);
    EXPECT_EQ(mover.stream.counters().asked, mover.asked) << "a camera that two were asked for counts once";
    EXPECT_FALSE(mover.closed);
    mover.stream.close("");
  }
  EXPECT_EQ(bye, "moved to another server of the fleet");
}

TEST(MovingStream, OneThatStandsStillMovesToo) {
  std::atomic<int> connections = 0;
  FakeServer fleet(
      [&](Peer& peer) {
        const bool first = ++connections == 1;
        open(peer);
        answer_one(peer, first ? kOld : kNew);
        if (first) peer.write(kGoNow);
        read_bye(peer);
      },
      2, FakeServer::usual_identity(), kTurns);
  Mover mover(fleet.address());
  ASSERT_TRUE(mover.stream.wait_open());
  mover.stream.ask(camera_at(0), {}, 0);
  EXPECT_TRUE(mover.loop.run_until(Clock::now() + 20s, [&] { return mover.moves == 1; }));
  EXPECT_EQ(mover.answers.size(), 1u) << "its camera has been answered";
  EXPECT_EQ(mover.stream.counters().complete, 1u);
  EXPECT_EQ(mover.stream.counters().asked, 1u);
  mover.stream.close("");
}

TEST(MovingStream, RefusalsAreTriedAgainWhileTheOldSessionServes) {
  std::atomic<int> connections = 0;
  std::atomic<bool> answered = false;
  FakeServer fleet(
      [&](Peer& peer) {
        const int number = ++connections;
        if (number == 1) {
          open(peer);
          answer_one(peer, kOld);
          peer.write(kGoNow);
          while (!answered && answer_one(peer, kOld)) {
          }
        } else if (number == 2) {
          peer.read();
          peer.write(protocol::Refused{protocol::RefusalCode::scene_unavailable, "not here"});
        } else {
          open(peer);
          answer_one(peer, kNew);
          answered = true;
        }
        read_bye(peer);
      },
      3, FakeServer::usual_identity(), kTurns);
  Mover mover(fleet.address());
  ASSERT_TRUE(mover.stream.wait_open());
  EXPECT_TRUE(mover.fly_until([&] { return mover.moves == 1; }));
  EXPECT_EQ(connections, 3);
  EXPECT_FALSE(mover.closed);
  mover.expect_order();
  mover.stream.close("");
}

TEST(MovingStream, ASessionThatEndsEarlyIsReplacedByTheOneOnItsWay) {
  std::atomic<int> connections = 0;
  std::atomic<bool> asked = false, ended = false;
  FakeServer fleet(
      [&](Peer& peer) {
        if (++connections == 1) {
          open(peer);
          answer_one(peer, kOld);
          peer.write(kGoNow);
          while (!asked) std::this_thread::sleep_for(1ms);
          peer.write(protocol::Bye{"time is over"});
          peer.hang_up();
          ended = true;
        } else {
          EXPECT_TRUE(peer.read());
          asked = true;
          while (!ended) std::this_thread::sleep_for(1ms);
          std::this_thread::sleep_for(50ms);
          peer.welcome(small_welcome(kWidth, kHeight, kLights));
          for (int i = 0; i < 3; ++i) answer_one(peer, kNew);
          read_bye(peer);
        }
      },
      2, FakeServer::usual_identity(), kTurns);
  Mover mover(fleet.address());
  ASSERT_TRUE(mover.stream.wait_open());
  EXPECT_TRUE(mover.fly_until([&] { return !mover.answers.empty() && mover.answers.back().words == kNew.words; }));
  EXPECT_EQ(mover.moves, 1);
  EXPECT_FALSE(mover.closed) << "there was always a session, or one on its way";
  mover.expect_order();
  mover.stream.close("");
}

TEST(MovingStream, WhatIsTakenBackIsNotBegun) {
  FakeServer fleet([&](Peer& peer) {
    open(peer);
    peer.write(protocol::Draining{100'000, protocol::Draining::kMoveNow});
    peer.write(protocol::Draining{protocol::Draining::kNoDeadline});
    read_bye(peer);
  });
  Mover mover(fleet.address());
  ASSERT_TRUE(mover.stream.wait_open());
  EXPECT_TRUE(mover.fly_until([&] { return mover.told<protocol::Draining>() == 2; }));
  mover.loop.run_until(Clock::now() + MovePolicy::kLongestSpread + 100ms, [&] { return mover.stream.is_moving(); });
  EXPECT_FALSE(mover.stream.is_moving());
  mover.stream.close("");
}

TEST(MovingStream, WhatTheNewServerSaysComesWhenItIsInForce) {
  std::atomic<int> connections = 0;
  FakeServer fleet(
      [&](Peer& peer) {
        const bool first = ++connections == 1;
        if (first) {
          open(peer);
          answer_one(peer, kOld);
          peer.write(kGoNow);
        } else {
          auto welcome = small_welcome(kWidth, kHeight, kLights);
          const auto lights = welcome.scene.lights;
          open(peer, welcome);
          peer.write(protocol::LightsChanged{lights, 1});
          peer.write(protocol::LightsChanged{lights, 2});
          answer_one_after(peer, 20, kNew);
        }
        read_bye(peer);
      },
      2, FakeServer::usual_identity(), kTurns);
  Mover mover(fleet.address());
  ASSERT_TRUE(mover.stream.wait_open());
  EXPECT_TRUE(mover.fly_until([&] {
    EXPECT_EQ(mover.told<protocol::LightsChanged>(), mover.moves == 0 ? 0u : 1u);
    return mover.moves == 1 || ::testing::Test::HasFailure();
  }));
  ASSERT_EQ(mover.told<protocol::LightsChanged>(), 1u) << "the newest of its kind";
  EXPECT_EQ(std::get<protocol::LightsChanged>(mover.messages.back()).version, 2u);
  mover.stream.close("");
}

}  // namespace
}  // namespace gnomon::client
