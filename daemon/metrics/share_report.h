// How a device was shared among tenants over the last while, as plain data.
#pragma once

#include <vector>

#include "common/clock.h"

namespace gnomon::daemon {

struct TenantReport {
  Nanoseconds service{};       // device time since the start
  double share = 0;            // of the device time that all got in the last while
  double expected_share = 0;   // by weight, among those that had work all the while; 0: it had not
  Nanoseconds lag{};           // what the policy owes it
  double predicted_error = 0;  // mean of |predicted - real| / real of its jobs in the last while
};

struct ShareReport {
  std::vector<TenantReport> tenants;  // by TenantId
  double jain =
      1;  // of service by weight, of tenants that had work all the while; 1 where there are fewer than two
  Nanoseconds worst_lag{};
};

}  // namespace gnomon::daemon
