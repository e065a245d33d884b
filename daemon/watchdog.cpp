#include "daemon/watchdog.h"

#include <algorithm>

#include "common/log.h"
#include "daemon/supervisor.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

// An idle render thread beats once a second: short of that a look may find nothing new, which is no harm. A hang is
// noticed by the supervisor at most this long after its own patience.
constexpr auto kLongestInterval = 500ms;
constexpr auto kStatusInterval = 5s;

}  // namespace

Watchdog::Watchdog(std::vector<Heartbeat*> heartbeats, std::function<std::string()> status)
    : heartbeats_(std::move(heartbeats)), status_(std::move(status)) {
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
    // All are asked: each remembers what was seen of it.
    const auto living =
        std::count_if(heartbeats_.begin(), heartbeats_.end(), [&](Heartbeat* h) { return h->lives(now); });
    if (static_cast<size_t>(living) == heartbeats_.size()) supervisor::alive();
    if (now < next_status) continue;
    next_status = now + kStatusInterval;
    supervisor::status(status_());
  }
}

}  // namespace gnomon::daemon
