// How tenants share a device: the part of the configuration that the render loop needs. A reload replaces it.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/clock.h"
#include "daemon/config/config.h"
#include "scheduler/degradation.h"
#include "scheduler/scheduler.h"

namespace gnomon::daemon {

// What a tenant may use; 0: no limit of its own.
struct TenantRates {
  double buffers_per_second = 0;  // vbps
  double bits_per_second = 0;     // visibility bits
  double bytes_per_second = 0;    // of datagrams
  double gpu_share = 0;           // device seconds a second, of all devices together; 1: one device's time
  friend bool operator==(const TenantRates&, const TenantRates&) = default;
};

struct TenantShare {
  scheduler::TenantScheduling scheduling;
  TenantRates rates;
  scheduler::DegradationLimits degradation;
};

// The quantum if the configuration says auto. Each cut costs a frame on a CPU far more than on a GPU, which overlaps it
// with other work: in bands of 4 ms lavapipe lost a quarter of its throughput.
inline constexpr Nanoseconds kQuantumOfGpu = std::chrono::milliseconds(4);
inline constexpr Nanoseconds kQuantumOfCpu = std::chrono::milliseconds(100);

struct SharingPolicy {
  std::string policy = "fair";
  double priority_floor = 0;
  std::optional<Nanoseconds> quantum = {};  // 0: frames are never cut; nullopt: by the kind of device
  uint32_t frames_in_flight = 3;            // on the device or waiting to be encoded
  std::vector<TenantShare> tenants;         // by TenantId
};

SharingPolicy sharing_policy_of(const Config& config);

}  // namespace gnomon::daemon
