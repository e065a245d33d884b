// What operators watch of the daemon as a whole. Any thread.
#pragma once

#include <chrono>

namespace prometheus {
class Counter;
class Gauge;
class Registry;
}  // namespace prometheus

namespace gnomon::daemon {

class OperationMetrics {
 public:
  explicit OperationMetrics(prometheus::Registry& registry);  // which outlives it

  void ready(bool ready);
  void reloaded(bool wholly);  // a configuration was read while running, and all of it was applied
  void certificate_expires(std::chrono::sys_seconds at);  // the first of the daemon's certificates that does

 private:
  prometheus::Gauge& ready_;
  prometheus::Gauge& certificate_expiry_;
  prometheus::Counter& reloads_;
  prometheus::Counter& failed_reloads_;
};

}  // namespace gnomon::daemon
