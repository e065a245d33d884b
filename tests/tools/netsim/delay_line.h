// Calls back at given times, in their order; calls of the same time come in the order in which they were asked for.
#pragma once

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
#include <functional>
#include <map>

#include "common/clock.h"

namespace gnomon::netsim {

// The io_context's thread.
class DelayLine {
 public:
  explicit DelayLine(asio::io_context& io) : timer_(io) {}

  void at(TimePoint when, std::function<void()> call) {
    const bool first = calls_.empty() || when < calls_.begin()->first;
    calls_.emplace(when, std::move(call));
    if (first) wait();
  }

  // What waits is never called.
  void clear() {
    timer_.cancel();
    calls_.clear();
  }

 private:
  void wait() {
    timer_.expires_at(calls_.begin()->first);
    timer_.async_wait([this](const asio::error_code& error) {
      if (!error) run();
    });
  }

  void run() {
    const TimePoint now = Clock::now();
    while (!calls_.empty() && calls_.begin()->first <= now) {
      const auto call = std::move(calls_.begin()->second);
      calls_.erase(calls_.begin());
      call();
    }
    if (!calls_.empty()) wait();
  }

  asio::steady_timer timer_;
  std::multimap<TimePoint, std::function<void()>> calls_;
};

}  // namespace gnomon::netsim
