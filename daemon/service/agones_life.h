// What a node tells Agones over its life: that it lives, that it is ready, that it goes. Agones' sidecar may start after
// the node, so that all is said until it is taken. Pure.
// https://agones.dev/site/docs/guides/client-sdks/rest/
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "common/clock.h"

namespace gnomon::daemon {

// One thread at a time.
class AgonesLife {
 public:
  enum class Call { health, ready, shutdown };

  // Agones' own patience is 5 s unless the fleet says otherwise (health.periodSeconds).
  static constexpr std::chrono::seconds kHealthEvery{2};
  static constexpr std::chrono::milliseconds kRetry{500};
  // After so many attempts the node goes without: its container's end says enough.
  static constexpr int kMostGoodbyes = 4;

  // Sessions may come from now on.
  void become_ready() { wants_ready_ = true; }
  // All sessions are gone: nothing but that is said any more. Agones takes the pod away then.
  void leave() {
    leaving_ = true;
    retry_at_ = TimePoint{};
  }

  // What is to be said now; nullopt: nothing before wake_at(). `alive`: whether the devices work on. The answer, or that
  // there was none, is told to answered() before the next call.
  std::optional<Call> next(TimePoint now, bool alive) {
    if (over()) return std::nullopt;
    if (leaving_) return now >= retry_at_ ? std::optional(Call::shutdown) : std::nullopt;
    if (now >= health_at_) {
      health_at_ = now + kHealthEvery;
      if (alive) return Call::health;
    }
    return asks_for_ready() && now >= retry_at_ ? std::optional(Call::ready) : std::nullopt;
  }

  // A sign of life that was not taken is not repeated: the next one comes soon.
  void answered(Call call, bool taken, TimePoint now) {
    if (call == Call::health) return;
    if (!taken) retry_at_ = now + kRetry;
    if (call == Call::ready) is_ready_ = taken;
    if (call == Call::shutdown) goodbyes_ = taken ? kMostGoodbyes : goodbyes_ + 1;
  }

  TimePoint wake_at() const {
    if (leaving_) return retry_at_;
    return asks_for_ready() ? std::min(health_at_, retry_at_) : health_at_;
  }

  bool over() const { return goodbyes_ >= kMostGoodbyes; }

 private:
  bool asks_for_ready() const { return wants_ready_ && !is_ready_; }

  bool wants_ready_ = false, is_ready_ = false, leaving_ = false;
  int goodbyes_ = 0;
  TimePoint health_at_{}, retry_at_{};
};

}  // namespace gnomon::daemon
