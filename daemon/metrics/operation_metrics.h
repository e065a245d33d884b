// What operators watch of the daemon as a whole. Any thread.
#pragma once

#include <chrono>
#include <cstdint>

namespace prometheus {
class Counter;
class Gauge;
class Registry;
}  // namespace prometheus

namespace gnomon::daemon {

// What is predicted to be needed of the memory that an account covers, and the most that may be; bytes.
struct MemoryAccount {
  uint64_t bytes = 0;
  uint64_t limit_bytes = 0;
};

class OperationMetrics {
 public:
  explicit OperationMetrics(prometheus::Registry& registry);  // which outlives it

  void ready(bool ready);
  void reloaded(bool wholly);  // a configuration was read while running, and all of it was applied
  void certificate_expires(std::chrono::sys_seconds at);  // the first of the daemon's certificates that does
  void memory(const MemoryAccount& scenes, const MemoryAccount& sessions);

 private:
  struct AccountGauges {
    prometheus::Gauge &bytes, &limit_bytes;
    void set(const MemoryAccount& account);
  };

  prometheus::Gauge& ready_;
  prometheus::Gauge& certificate_expiry_;
  prometheus::Counter& reloads_;
  prometheus::Counter& failed_reloads_;
  AccountGauges scenes_;
  AccountGauges sessions_;
};

}  // namespace gnomon::daemon
