// Admission control: decides whether the node and a tenant's limits leave room for one more session, and what would fit
// if they do not.
//
// A session books what it asks for: rate x (frames, bits, predicted bytes and device time), memory on the device, and
// the most that it can make the host keep for it. A session that asks for no rate books memory alone and gets what the
// others leave. Pure bookkeeping: it reads no clock and takes no locks; the caller serialises all calls.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "common/ids.h"
#include "common/sample_counts.h"
#include "scheduler/cost_model.h"

namespace gnomon::scheduler {

// What all sessions of the node may book together; 0: no limit.
struct NodeLimits {
  double capacity = 0;      // share of the devices' time; 1 for each device
  uint64_t host_bytes = 0;  // of the host's memory
};

// What all sessions of one tenant may book together; 0: no limit.
struct TenantLimits {
  uint32_t width = 0, height = 0;  // pixels; of each session
  double buffers_per_second = 0;
  double bits_per_second = 0;
  double bytes_per_second = 0;
  double gpu_share = 0;       // of the device, 0 to 1
  uint64_t memory_bytes = 0;  // of the devices' memory
  uint64_t host_bytes = 0;
  uint64_t reserved_host_bytes = 0;  // of the node's; the other tenants leave it free
};

// What a client asks for.
struct Demand {
  uint32_t width = 0, height = 0;  // pixels
  uint32_t lights = 0;
  double rate_hz = 0;       // 0: no rate
  bool references = false;  // earlier frames are kept, so that further ones may refer to them
  uint32_t areas = 0;       // of the lights, those with an extent
  SampleCounts samples = {};
};

// The resources that one session holds until it is released.
struct Booking {
  double buffers_per_second = 0;
  double bits_per_second = 0;
  double bytes_per_second = 0;
  double load = 0;  // of the device: 1 is all of it
  uint64_t memory_bytes = 0;
  uint64_t host_bytes = 0;
};

// `sessions` is for callers that count sessions: book() never returns it.
enum class Limit { sessions, size, buffers, bits, bytes, gpu_share, memory, host_memory, capacity };
std::string_view to_string(Limit limit);

// A refusal: the first limit that the demand exceeds, and smaller demands that would be admitted instead; 0 if none.
struct AdmissionRejection {
  Limit limit = Limit::capacity;
  uint32_t fit_width = 0, fit_height = 0;  // at the requested rate
  double fit_rate_hz = 0;                  // at the requested size
};

class AdmissionControl {
 public:
  // `tenants` is indexed by TenantId. Existing bookings are kept, even if they exceed the new limits.
  void set_limits(const NodeLimits& node, std::vector<TenantLimits> tenants);

  // Books the demand if it fits. `model`: the costs of the scene that the client asks for, with its samples; a model without measurements
  // predicts no load. Precondition: set_limits has named the tenant.
  std::variant<Booking, AdmissionRejection> book(TenantId tenant, const Demand& demand, const CostModel& model);
  // Precondition: `booking` was returned by book() for this tenant and was not released yet.
  void release(TenantId tenant, const Booking& booking);

  uint64_t host_bytes() const { return all_.host_bytes; }  // of all sessions
  uint64_t host_bytes(TenantId tenant) const {
    return tenant.value < of_tenant_.size() ? of_tenant_[tenant.value].host_bytes : 0;
  }

 private:
  std::optional<Limit> obstacle(TenantId tenant, const Demand& demand, const CostModel& model) const;
  // The highest whole rate that would be admitted; 0 if there is none.
  double fitting_rate(TenantId tenant, Demand demand, const CostModel& model) const;
  uint64_t host_bytes_reserved_for_others(TenantId tenant) const;

  NodeLimits node_;
  std::vector<TenantLimits> limits_;
  Booking all_;                     // the sum of all bookings
  std::vector<Booking> of_tenant_;  // their sums, by TenantId
};

}  // namespace gnomon::scheduler
