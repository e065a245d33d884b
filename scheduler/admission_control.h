// Admission control: decides whether the device and a tenant's limits leave room for one more session, and what would
// fit if they do not.
//
// A session books what it asks for: rate x (frames, bits, predicted bytes and device time), and memory. A session that
// asks for no rate books memory alone and gets what the others leave. Pure bookkeeping: it reads no clock and takes no
// locks; the caller serialises all calls.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "common/ids.h"
#include "scheduler/cost_model.h"

namespace gnomon::scheduler {

// What all sessions of one tenant may book together; 0: no limit.
struct TenantLimits {
  uint32_t sessions = 0;
  uint32_t width = 0, height = 0;  // pixels; of each session
  double buffers_per_second = 0;
  double bits_per_second = 0;
  double bytes_per_second = 0;
  double gpu_share = 0;  // of the device, 0 to 1
  uint64_t memory_bytes = 0;
};

// What a client asks for.
struct Demand {
  uint32_t width = 0, height = 0;  // pixels
  uint32_t lights = 0;
  double rate_hz = 0;  // 0: no rate
};

// The resources that one session holds until it is released.
struct Booking {
  double buffers_per_second = 0;
  double bits_per_second = 0;
  double bytes_per_second = 0;
  double load = 0;  // of the device: 1 is all of it
  uint64_t memory_bytes = 0;
};

enum class Limit { sessions, size, buffers, bits, bytes, gpu_share, memory, capacity };
std::string_view to_string(Limit limit);

// A refusal: the first limit that the demand exceeds, and smaller demands that would be admitted instead; 0 if none.
struct AdmissionRejection {
  Limit limit = Limit::capacity;
  uint32_t fit_width = 0, fit_height = 0;  // at the requested rate
  double fit_rate_hz = 0;                  // at the requested size
};

class AdmissionControl {
 public:
  // `capacity`: the share of the device that all sessions may book together; 1: all of it, 0: no limit. `tenants` is
  // indexed by TenantId. Existing bookings are kept, even if they exceed the new limits.
  void set_limits(double capacity, std::vector<TenantLimits> tenants);

  // Books the demand if it fits. `model`: the costs of the scene that the client asks for; a model without measurements
  // predicts no load. Precondition: set_limits has named the tenant.
  std::variant<Booking, AdmissionRejection> book(TenantId tenant, const Demand& demand, const CostModel& model);
  // Precondition: `booking` was returned by book() for this tenant and was not released yet.
  void release(TenantId tenant, const Booking& booking);

  uint32_t sessions(TenantId tenant) const { return booked_[tenant.value].sessions; }

 private:
  struct Booked {
    uint32_t sessions = 0;
    Booking sum;
  };

  std::optional<Limit> obstacle(TenantId tenant, const Demand& demand, const CostModel& model) const;

  double capacity_ = 0;
  double load_ = 0;
  std::vector<TenantLimits> limits_;
  std::vector<Booked> booked_;
};

}  // namespace gnomon::scheduler
