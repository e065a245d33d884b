#include "daemon/config/terms.h"

namespace gnomon::daemon {

Terms terms_of(const Config& config) {
  Terms terms;
  terms.policy = config.scheduler.policy;
  terms.priority_floor = config.scheduler.priority_floor_percent / 100.0;
  terms.quantum = config.scheduler.quantum;
  terms.frames_in_flight = config.render.frames_in_flight;
  for (const TenantConfig& tenant : config.tenants) {
    terms.tenants.push_back({{tenant.weight, tenant.priority},
                             {double(tenant.max_vbps), double(tenant.max_bits_per_s),
                              double(tenant.max_bytes_per_s), tenant.max_gpu_percent / 100.0},
                             {tenant.least_rate_percent / 100.0, tenant.least_size_percent / 100.0,
                              tenant.least_lights_percent / 100.0}});
  }
  return terms;
}

}  // namespace gnomon::daemon
