// How the device was shared among tenants: what each got, and whether it always had work, over the last while.
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/config/sharing_policy.h"
#include "daemon/metrics/share_report.h"
#include "scheduler/rate_limit.h"

namespace gnomon::daemon {

// The render loop's.
class ShareAccount {
 public:
  void set_terms(const SharingPolicy& terms);
  // Of the tenant's rates this device allows so much: 0 to 1. At first all.
  void set_part(TenantId tenant, double part);

  void asked(TenantId tenant) { ++tenants_[tenant.value].waiting; }
  void left_queue(TenantId tenant) { --tenants_[tenant.value].waiting; }
  // Before every round of picks that has room: who has no work now was not busy all the while.
  void look();

  // A job was submitted: it counts against the tenant's rates.
  void started(TenantId tenant, bool begins_frame, uint64_t bits, TimePoint now);
  void sent(TenantId tenant, size_t bytes, TimePoint now);
  void finished(TenantId tenant, Nanoseconds predicted, Nanoseconds real, TimePoint now);
  // From when the tenant may start a frame.
  TimePoint open_at(TenantId tenant) const;

  ShareReport report(const scheduler::Scheduler& policy);  // and begins a new while

 private:
  struct Tenant {
    double weight = 1;
    TenantRates rates;
    double part = 1;
    scheduler::RateLimit buffers, bits, bytes, gpu;
    uint32_t waiting = 0;  // sessions in the scheduler's queue
    bool always_busy = true;
    Nanoseconds service{}, recent{};
    double errors = 0;  // sum, relative
    uint64_t jobs = 0;
  };

  std::vector<Tenant> tenants_;
};

}  // namespace gnomon::daemon
