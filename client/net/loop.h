// One thread's event loop. Everything in client/ that names a Loop is served by whoever runs that loop, on that
// thread: no call back comes from anywhere else, and nothing here needs a lock.
//
// An engine polls it once a frame; a program that only waits runs it.
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

  // Serves events until `done` says so (asked before each event) or until `deadline`. False: the deadline passed.
  bool run_until(TimePoint deadline, const std::function<bool()>& done);

  asio::io_context& context();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// Calls back once, at the time it was last armed for. Dropped or disarmed, it never calls.
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
