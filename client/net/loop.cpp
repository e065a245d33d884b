#include "client/net/loop.h"

#include <asio/executor_work_guard.hpp>
#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>

namespace gnomon::client {

struct Loop::State {
  asio::io_context context{1};
  // Keeps run_one_until() waiting while no operation is pending.
  asio::executor_work_guard<asio::io_context::executor_type> work{context.get_executor()};
};

Loop::Loop() : state_(std::make_unique<State>()) {}
Loop::~Loop() = default;

void Loop::poll() { state_->context.poll(); }

bool Loop::run_until(TimePoint deadline, const std::function<bool()>& done) {
  while (!done()) {
    if (state_->context.run_one_until(deadline) == 0) return done();
  }
  return true;
}

asio::io_context& Loop::context() { return state_->context; }

struct Timer::State {
  State(Loop& loop, std::function<void()> callback) : timer(loop.context()), on_time(std::move(callback)) {}

  asio::steady_timer timer;
  std::function<void()> on_time;
  uint64_t generation = 0;  // expiries that carry an older generation are ignored
};

Timer::Timer(Loop& loop, std::function<void()> on_time)
    : state_(std::make_shared<State>(loop, std::move(on_time))) {}

Timer::~Timer() { disarm(); }

void Timer::arm(TimePoint when) {
  const uint64_t generation = ++state_->generation;
  state_->timer.expires_at(when);
  state_->timer.async_wait([weak = std::weak_ptr(state_), generation](const asio::error_code& error) {
    const auto state = weak.lock();
    if (!error && state && state->generation == generation) state->on_time();
  });
}

void Timer::disarm() {
  ++state_->generation;
  state_->timer.cancel();
}

}  // namespace gnomon::client
