// Whether the device and a tenant's limits leave room for one more session, and if not, what would fit.
//
// Sessions book what they ask for: rate x (frames, bits, predicted bytes and device time), and memory. One that asks for no rate
// books no rate: it gets what is left. Pure bookkeeping: no clock, no locks, one thread at a time.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <variant>
#include <vector>

#include "common/ids.h"
#include "scheduler/cost_model.h"

namespace gnomon::scheduler {

// 0: no limit.
struct TenantLimits {
  uint32_t sessions = 0;
  uint32_t width = 0, height = 0;  // of one session
  double buffers_per_second = 0;
  double bits_per_second = 0;
  double bytes_per_second = 0;
  double gpu_share = 0;  // of the device, 0 to 1
  uint64_t memory_bytes = 0;
};

struct Demand {
  uint32_t width = 0, height = 0;
  uint32_t lights = 0;
  double rate_hz = 0;
};

// What one session holds.
struct Booking {
  double buffers_per_second = 0;
  double bits_per_second = 0;
  double bytes_per_second = 0;
  double load = 0;  // of the device: 1 is all of it
  uint64_t memory_bytes = 0;
};

enum class Limit { sessions, size, buffers, bits, bytes, gpu_share, memory, capacity };
std::string_view to_string(Limit limit);

// What would be admitted in its place; 0 where nothing of that kind would.
struct Misfit {
  Limit limit = Limit::capacity;
  uint32_t fit_width = 0, fit_height = 0;  // at the asked rate
  double fit_rate_hz = 0;                  // at the asked size
};

class Admission {
 public:
  // `capacity`: what all sessions may book of the device together, 1: all of it; 0: no limit. Bookings stay.
  void set_limits(double capacity, std::vector<TenantLimits> tenants);

  // `model`: of the scene that it asks for.
  std::variant<Booking, Misfit> book(TenantId tenant, const Demand& demand, const CostModel& model);
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
