// Tells the supervisor, and who asks for our health, that we live, as long as every render thread does: a hung device
// ends in a restart.
#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "daemon/service/heartbeat.h"

namespace gnomon::daemon {

class Watchdog {
 public:
  // `alive`: told when each of them gave a sign. `status`: a line for the supervisor, asked for once in a while. All are
  // used from a thread of its own. Outlived by the heartbeats: each must beat.
  Watchdog(std::vector<Heartbeat*> heartbeats, std::function<void(TimePoint)> alive,
           std::function<std::string()> status);
  ~Watchdog();

 private:
  void watch(std::chrono::microseconds interval);

  std::vector<Heartbeat*> heartbeats_;
  std::function<void(TimePoint)> alive_;
  std::function<std::string()> status_;
  std::mutex mutex_;
  std::condition_variable ending_;
  bool ended_ = false;  // guarded by mutex_
  std::thread thread_;
};

}  // namespace gnomon::daemon
