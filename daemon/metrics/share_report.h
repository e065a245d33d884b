// How a device was shared among tenants since the last report, as plain data.
#pragma once

#include <vector>

#include "common/clock.h"

namespace gnomon::daemon {

struct TenantReport {
  Nanoseconds service{};       // device time since the start
  double share = 0;            // of all tenants' device time since the last report
  double expected_share = 0;   // by weight, among the tenants that always had work; 0 if this one had not
  Nanoseconds lag{};           // device time that the policy owes the tenant
  double predicted_error = 0;  // mean of |predicted - real| / real over its jobs since the last report
};

struct ShareReport {
  std::vector<TenantReport> tenants;  // by TenantId
  double jain =
      1;  // Jain's index of device time by weight, of tenants that always had work; 1 if these are fewer than two
  Nanoseconds worst_lag{};
};

}  // namespace gnomon::daemon
