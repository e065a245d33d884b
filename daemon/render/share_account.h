// How the device was shared among tenants since the last report: what each got, and whether it always had work.
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/config/sharing_policy.h"
#include "daemon/metrics/share_report.h"
#include "scheduler/rate_limit.h"

namespace gnomon::daemon {

// Belongs to the render thread.
class ShareAccount {
 public:
  void set_sharing(const SharingPolicy& sharing);
  // This device allows `fraction` of the tenant's rates, 0 to 1; initially 1.
  void set_fraction(TenantId tenant, double fraction);

  void queued(TenantId tenant) { ++tenants_[tenant.value].waiting; }
  void left_queue(TenantId tenant) { --tenants_[tenant.value].waiting; }
  // Called before every round of picks that has room: a tenant without work at that moment was not always busy.
  void sample_backlog();

  // A job was submitted: it counts against the tenant's rates.
  void started(TenantId tenant, bool begins_frame, uint64_t bits, TimePoint now);
  void sent(TenantId tenant, size_t bytes, TimePoint now);
  void finished(TenantId tenant, Nanoseconds predicted, Nanoseconds real, TimePoint now);
  // The time from which the tenant may start a frame.
  TimePoint eligible_at(TenantId tenant) const;

  // The shares since the last report.
  ShareReport report(const scheduler::Scheduler& policy);

 private:
  static constexpr Nanoseconds kBurst = std::chrono::milliseconds(100);  // of rates: clients are not synchronised

  struct Tenant {
    double weight = 1;
    TenantRates rates;
    double fraction = 1;
    scheduler::RateLimit buffers{0, kBurst}, bits{0, kBurst}, bytes{0, kBurst}, gpu{0, kBurst};
    uint32_t waiting = 0;  // sessions in the scheduler's queue
    bool always_busy = true;
    Nanoseconds service{}, recent{};
    double errors = 0;  // sum, relative
    uint64_t jobs = 0;
  };
  static void set_rates(Tenant& tenant);

  std::vector<Tenant> tenants_;
};

}  // namespace gnomon::daemon
