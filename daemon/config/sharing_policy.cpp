#include "daemon/config/sharing_policy.h"

namespace gnomon::daemon {

SharingPolicy sharing_policy_of(const Config& config) {
  SharingPolicy sharing;
  sharing.policy = config.scheduler.policy;
  sharing.priority_floor = config.scheduler.priority_floor_percent / 100.0;
  sharing.quantum = config.scheduler.quantum;
  sharing.frames_in_flight = config.render.frames_in_flight;
  for (const TenantConfig& tenant : config.tenants) {
    sharing.tenants.push_back({{tenant.weight, tenant.priority},
                               {double(tenant.max_vbps), double(tenant.max_bits_per_s),
                                double(tenant.max_bytes_per_s), tenant.max_gpu_percent / 100.0},
                               {tenant.least_rate_percent / 100.0, tenant.least_size_percent / 100.0,
                                tenant.least_lights_percent / 100.0, tenant.least_samples}});
  }
  return sharing;
}

}  // namespace gnomon::daemon
