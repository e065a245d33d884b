// Calls functions at given times, in the order of the times; calls for the same time are made in the order of requests.
#pragma once

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>
#include <functional>
#include <map>

#include "common/clock.h"

namespace gnomon::netsim {

// Used on the io_context's thread.
class DelayLine {
 public:
  explicit DelayLine(asio::io_context& io) : timer_(io) {}

  void at(TimePoint when, std::function<void()> call) {
    const bool first = calls_.empty() || when < calls_.begin()->first;
    calls_.emplace(when, std::move(call));
    if (first) wait();
  }

  // Drops the functions that wait, without calling them.
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
