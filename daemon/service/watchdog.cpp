#include "daemon/service/watchdog.h"

#include <algorithm>

#include "common/within_memory.h"
#include "daemon/service/supervisor.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

// An idle render thread beats once a second, so that a check may find no new beat. The supervisor notices a hang at most
// this long after its own patience.
constexpr auto kLongestInterval = 500ms;
constexpr auto kStatusInterval = 5s;

}  // namespace

Watchdog::Watchdog(std::vector<Heartbeat*> heartbeats, std::function<void(TimePoint)> alive,
                   std::function<std::string()> status)
    : liveness_(std::move(heartbeats)), alive_(std::move(alive)), status_(std::move(status)) {
  const auto patience = supervisor::patience().value_or(std::chrono::hours(1));
  const auto interval = std::min<std::chrono::microseconds>(patience / 4, kLongestInterval);
  thread_ = std::thread([this, interval] { watch(interval); });
}

Watchdog::~Watchdog() {
  {
    std::lock_guard lock(mutex_);
    ended_ = true;
  }
  ending_.notify_all();
  thread_.join();
}

void Watchdog::watch(std::chrono::microseconds interval) {
  TimePoint next_status = Clock::now() + kStatusInterval;
  std::unique_lock lock(mutex_);
  while (!ending_.wait_for(lock, interval, [this] { return ended_; })) {
    const TimePoint now = Clock::now();
    if (liveness_.check(now)) {
      supervisor::alive();
      done_or_dropped("a sign of life", [&] { alive_(now); });
    }
    if (now < next_status) continue;
    next_status = now + kStatusInterval;
    done_or_dropped("a status line", [&] { supervisor::status(status_()); });
  }
}

}  // namespace gnomon::daemon
