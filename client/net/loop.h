// The event loop of one thread. Everything in client/ that takes a Loop is served by the thread that runs that loop: no
// callback is made on another thread, and nothing here needs a lock.
//
// An engine calls poll() once a frame; a program that only waits calls run_until().
#pragma once

#include <functional>
#include <memory>

#include "common/clock.h"

namespace asio {
class io_context;
}

namespace gnomon::client {

class Loop {
 public:
  Loop();
  ~Loop();

  // Serves what is ready now and returns without waiting.
  void poll();

  // Serves events until `done` returns true (it is called before each event) or until `deadline`. False if the deadline
  // passed.
  bool run_until(TimePoint deadline, const std::function<bool()>& done);

  asio::io_context& context();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Calls `on_time` once, on the loop, at the time for which it was last armed; never if it was disarmed or destroyed.
class Timer {
 public:
  Timer(Loop& loop, std::function<void()> on_time);
  ~Timer();

  void arm(TimePoint when);
  void disarm();

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace gnomon::client
