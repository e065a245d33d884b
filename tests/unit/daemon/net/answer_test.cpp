// Coroutines that wait for another thread: the answer may come at once, later, or never.
#include "daemon/net/answer.h"

#include <gtest/gtest.h>
#include <asio/co_spawn.hpp>
#include <asio/detached.hpp>

#include <thread>

namespace gnomon::daemon {
namespace {

using Number = std::unique_ptr<int>;  // move-only, as StoredSession is

// `got` becomes the answer, or -1 if it is not waited for any more.
asio::awaitable<void> wait(asio::io_context& io, Ask<Number> ask, std::shared_ptr<int> got,
                           std::stop_token unwanted) {
  const std::optional<Number> number = co_await answer_of(io, ask, unwanted);
  *got = number ? **number : -1;
}

class AnswerTest : public testing::Test {
 protected:
  void spawn(Ask<Number> ask) {
    asio::co_spawn(*io_, wait(*io_, std::move(ask), got_, departure_.get_token()), asio::detached);
  }

  std::unique_ptr<asio::io_context> io_ = std::make_unique<asio::io_context>(1);
  std::stop_source departure_;
  std::shared_ptr<int> got_ = std::make_shared<int>(0);
};

TEST_F(AnswerTest, MayComeWhileItIsAskedFor) {
  spawn([](const OnAnswer<Number>& on_answer) { on_answer(std::make_unique<int>(7)); });
  io_->run();
  EXPECT_EQ(*got_, 7);
}

TEST_F(AnswerTest, MayComeFromAnotherThread) {
  std::thread other;
  spawn([&](OnAnswer<Number> on_answer) {
    other = std::thread([on_answer = std::move(on_answer)] { on_answer(std::make_unique<int>(8)); });
  });
  io_->run();
  other.join();
  EXPECT_EQ(*got_, 8);
}

TEST_F(AnswerTest, ThatNeverComesLeavesNothingBehind) {
  OnAnswer<Number> kept;
  spawn([&](OnAnswer<Number> on_answer) { kept = std::move(on_answer); });
  io_->poll();
  EXPECT_EQ(got_.use_count(), 2) << "the coroutine waits";
  io_.reset();
  EXPECT_EQ(got_.use_count(), 1) << "and has gone with its event loop";
}

TEST_F(AnswerTest, ThatComesBeforeTheEndButIsNotSeenIsDroppedWithTheEventLoop) {
  OnAnswer<Number> kept;
  spawn([&](OnAnswer<Number> on_answer) { kept = std::move(on_answer); });
  io_->poll();
  kept(std::make_unique<int>(9));
  io_.reset();
  EXPECT_EQ(*got_, 0);
  EXPECT_EQ(got_.use_count(), 1);
}

TEST_F(AnswerTest, IsNotWaitedForOnceNobodyWantsIt) {
  OnAnswer<Number> kept;
  spawn([&](OnAnswer<Number> on_answer) { kept = std::move(on_answer); });
  io_->poll();
  departure_.request_stop();
  io_->poll();
  EXPECT_EQ(*got_, -1);
  EXPECT_EQ(got_.use_count(), 1) << "the coroutine has ended";
  kept(std::make_unique<int>(9));  // and the answer that comes later is dropped
  io_->restart();
  io_->poll();
  EXPECT_EQ(*got_, -1);
}

TEST_F(AnswerTest, IsNotWaitedForIfNobodyWantedItFromTheStart) {
  departure_.request_stop();
  spawn([](const OnAnswer<Number>&) {});
  io_->run();
  EXPECT_EQ(*got_, -1);
}

}  // namespace
}  // namespace gnomon::daemon
