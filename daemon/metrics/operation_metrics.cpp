#include "daemon/metrics/operation_metrics.h"

#include "daemon/metrics/prometheus_families.h"

namespace gnomon::daemon {
namespace {

prometheus::Family<prometheus::Counter>& reload_family(prometheus::Registry& registry) {
  return counter_family(registry, "gnomon_config_reloads_total",
                        "Configurations read while running, taken or not.");
}

prometheus::Family<prometheus::Gauge>& account_family(prometheus::Registry& registry) {
  return gauge_family(registry, "gnomon_account_bytes", "Memory that scenes or sessions are predicted to need.");
}

prometheus::Family<prometheus::Gauge>& account_limit_family(prometheus::Registry& registry) {
  return gauge_family(registry, "gnomon_account_limit_bytes",
                      "Memory that scenes or sessions may come to need; what would need more is refused.");
}

std::array<prometheus::Counter*, kSessionMoves> move_counters(prometheus::Registry& registry) {
  auto& family =
      counter_family(registry, "gnomon_session_moves_total",
                     "Sessions whose clients were asked to move to another node of the fleet, and what became "
                     "of them.");
  const auto of = [&](const char* outcome) { return &family.Add({{"outcome", outcome}}); };
  return {of("asked"), of("left"), of("stayed"), of("kept")};
}

}  // namespace

OperationMetrics::OperationMetrics(prometheus::Registry& registry)
    : ready_(gauge_family(registry, "gnomon_ready", "1: new clients are served.").Add({})),
      draining_(
          gauge_family(registry, "gnomon_draining", "1: nobody is let in, as an operator wants it or it stops.")
              .Add({})),
      certificate_expiry_(
          gauge_family(registry, "gnomon_certificate_expiry_timestamp_seconds",
                       "When the first of the daemon's certificates expires, its clients' authorities included.")
              .Add({})),
      reloads_(reload_family(registry).Add({{"result", "done"}})),
      failed_reloads_(reload_family(registry).Add({{"result", "failed"}})),
      scenes_{account_family(registry).Add({{"account", "scenes"}}),
              account_limit_family(registry).Add({{"account", "scenes"}})},
      sessions_{account_family(registry).Add({{"account", "sessions"}}),
                account_limit_family(registry).Add({{"account", "sessions"}})},
      moves_{},
      registry_(registry) {}

void OperationMetrics::ready(bool ready, bool draining) {
  ready_.Set(ready ? 1 : 0);
  draining_.Set(draining ? 1 : 0);
}

// A node of a fleet has the series from its start, so that the first move counts; others have room for few, and none.
void OperationMetrics::moved(SessionMove move) {
  const size_t outcome = static_cast<size_t>(move);
  (moves_[outcome] ? moves_[outcome] : move_counters(registry_)[outcome])->Increment();
}

void OperationMetrics::expect_door() {
  moves_ = move_counters(registry_);
  door_questions_ = &counter_family(registry_, "gnomon_door_questions_total",
                                    "Questions of the fleet's doors that were answered.")
                         .Add({});
}

void OperationMetrics::asked_by_door() {
  if (door_questions_) door_questions_->Increment();
}

void OperationMetrics::reloaded(bool wholly) { (wholly ? reloads_ : failed_reloads_).Increment(); }

void OperationMetrics::AccountGauges::set(const MemoryAccount& account) {
  bytes.Set(static_cast<double>(account.bytes));
  limit_bytes.Set(static_cast<double>(account.limit_bytes));
}

void OperationMetrics::memory(const MemoryAccount& scenes, const MemoryAccount& sessions) {
  scenes_.set(scenes);
  sessions_.set(sessions);
}

void OperationMetrics::certificate_expires(std::chrono::sys_seconds at) {
  certificate_expiry_.Set(static_cast<double>(at.time_since_epoch().count()));
}

}  // namespace gnomon::daemon
