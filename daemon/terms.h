// On what terms the device is shared: what the render loop needs of the configuration. May change while it runs.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/clock.h"
#include "daemon/config.h"
#include "scheduler/degradation.h"
#include "scheduler/scheduler.h"

namespace gnomon::daemon {

// What a tenant may use; 0: no limit of its own.
struct TenantRates {
  double buffers_per_second = 0;  // vbps
  double bits_per_second = 0;     // visibility bits
  double bytes_per_second = 0;    // of datagrams
  double gpu_share = 0;           // of one device, 0 to 1
};

struct TenantShare {
  scheduler::TenantTerms terms;
  TenantRates rates;
  scheduler::DegradationTerms degradation;
};

struct Terms {
  std::string policy = "fair";
  double priority_floor = 0;
  Nanoseconds slice = std::chrono::milliseconds(4);  // 0: frames are never cut
  uint32_t frames_in_flight = 3;                     // on the device or waiting to be encoded
  std::vector<TenantShare> tenants;                  // by TenantId
};

Terms terms_of(const Config& config);

}  // namespace gnomon::daemon
