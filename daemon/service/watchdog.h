// Notifies the supervisor and the health page as long as every render thread is alive, so that a hung device ends in a
// restart of the daemon.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "daemon/service/liveness.h"

namespace gnomon::daemon {

class Watchdog {
 public:
  // `alive` is called when all heartbeats have beaten since its last call; `status` returns a line for the supervisor
  // and is called every few seconds; both from a thread of the watchdog's own. The heartbeats outlive the watchdog.
  Watchdog(std::vector<Heartbeat*> heartbeats, std::function<void(TimePoint)> alive,
           std::function<std::string()> status);
  ~Watchdog();

 private:
  void watch(std::chrono::microseconds interval);

  Liveness liveness_;
  std::function<void(TimePoint)> alive_;
  std::function<std::string()> status_;
  std::mutex mutex_;
  std::condition_variable ending_;
  bool ended_ = false;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace gnomon::daemon
