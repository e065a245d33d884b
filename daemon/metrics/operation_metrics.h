// What operators watch of the daemon as a whole. Any thread.
#pragma once

#include <array>
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

// What became of a session whose client was asked to move to another node: each is asked, and then either has left, or
// stayed until it ended here, or was kept, as that was taken back.
enum class SessionMove : uint8_t { asked, left, stayed, kept };
inline constexpr size_t kSessionMoves = 4;

class OperationMetrics {
 public:
  explicit OperationMetrics(prometheus::Registry& registry);  // which outlives it

  void ready(bool ready, bool draining);
  void moved(SessionMove move);
  void expect_door();  // once, before anybody asks: only nodes of a fleet have the series
  void asked_by_door();
  void reloaded(bool wholly);  // a configuration was read while running, and all of it was applied
  void certificate_expires(std::chrono::sys_seconds at);  // the first of the daemon's certificates that does
  void memory(const MemoryAccount& scenes, const MemoryAccount& sessions);

 private:
  struct AccountGauges {
    prometheus::Gauge &bytes, &limit_bytes;
    void set(const MemoryAccount& account);
  };

  prometheus::Gauge& ready_;
  prometheus::Gauge& draining_;
  prometheus::Gauge& certificate_expiry_;
  prometheus::Counter& reloads_;
  prometheus::Counter& failed_reloads_;
  AccountGauges scenes_;
  AccountGauges sessions_;
  std::array<prometheus::Counter*, kSessionMoves> moves_;  // by SessionMove
  prometheus::Registry& registry_;
  prometheus::Counter* door_questions_ = nullptr;
};

}  // namespace gnomon::daemon
