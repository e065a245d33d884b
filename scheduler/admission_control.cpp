#include "scheduler/admission_control.h"

#include <algorithm>
#include <cmath>

#include "scheduler/sample_costs.h"

namespace gnomon::scheduler {
namespace {

// What a session holds in memory: triangle id and depth of each pixel on the device; the masks there and on the host.
constexpr uint64_t kBytesPerPixel = 8;
constexpr uint64_t kCopiesOfMasks = 2;

// The most that a session makes the host keep, in frames of its masks. Coded masks are no longer than raw ones but for a
// few bytes a slice. What each figure bounds: daemon/link/stored_frames.h, daemon/frame/session_references.h.
constexpr uint64_t kFramesBeingCoded = 2;
constexpr uint64_t kStoredFrames = 4;
constexpr double kParity = 1.5;  // with the parity datagrams that protect it
constexpr uint64_t kReferences = 12;
constexpr double kReferenceOverhead = 1.2;      // its tiles' classes
constexpr uint64_t kSessionBytes = 192 * 1024;  // its record, keys, queues, connection, what is known of its link

constexpr uint32_t kTileSide = 8;
constexpr int kSizesTried = 15;    // in sixteenths of the requested size
constexpr double kMostRate = 1e6;  // that is offered; as whole numbers of doubles go

uint64_t pixels_of(const Demand& d) { return uint64_t{d.width} * d.height; }

uint64_t bits_of(const Demand& d) { return weighted_bits(pixels_of(d), d.lights, d.areas, d.samples); }

uint64_t mask_bytes_of(const Demand& d) {
  const uint32_t planes =
      d.lights + d.areas * (planes_of(d.samples.per_light) - 1) + planes_of(d.samples.occlusion);
  return pixels_of(d) * planes / 8;
}

uint64_t host_bytes_of(const Demand& d) {
  const double masks = static_cast<double>(mask_bytes_of(d));
  double frames = kFramesBeingCoded + kStoredFrames * kParity;
  if (d.references) frames += kReferences * kReferenceOverhead;
  return kSessionBytes + static_cast<uint64_t>(frames * masks);
}

Booking booking_of(const Demand& d, const CostModel& model) {
  const uint64_t pixels = pixels_of(d);
  const Nanoseconds cost =
      model.knows() ? model.predict_within_reach({pixels, bits_of(d), true}).total() : Nanoseconds{};
  return {.buffers_per_second = d.rate_hz,
          .bits_per_second = d.rate_hz * static_cast<double>(bits_of(d)),
          .bytes_per_second = d.rate_hz * model.predict_bytes(bits_of(d)),
          .load = d.rate_hz * to_seconds(cost),
          .memory_bytes = pixels * kBytesPerPixel + mask_bytes_of(d) * kCopiesOfMasks,
          .host_bytes = host_bytes_of(d)};
}

void add(Booking& sum, const Booking& b, int sign) {
  sum.buffers_per_second += sign * b.buffers_per_second;
  sum.bits_per_second += sign * b.bits_per_second;
  sum.bytes_per_second += sign * b.bytes_per_second;
  sum.load += sign * b.load;
  sum.memory_bytes += sign > 0 ? b.memory_bytes : 0 - b.memory_bytes;
  sum.host_bytes += sign > 0 ? b.host_bytes : 0 - b.host_bytes;
}

// The tolerance covers rounding: a sum to which bookings were added and released again is not exactly 0.
bool beyond(double sum, double limit) { return limit > 0 && sum > limit * (1 + 1e-9); }
bool beyond(uint64_t sum, uint64_t limit) { return limit > 0 && sum > limit; }

uint32_t scaled(uint32_t side, int sixteenths) {
  return std::min(side, std::max(kTileSide, side * static_cast<uint32_t>(sixteenths) / 16 / kTileSide * kTileSide));
}

}  // namespace

std::string_view to_string(Limit limit) {
  switch (limit) {
    case Limit::sessions: return "sessions";
    case Limit::size: return "size";
    case Limit::buffers: return "visibility buffers a second";
    case Limit::bits: return "visibility bits a second";
    case Limit::bytes: return "bytes a second";
    case Limit::gpu_share: return "share of the device";
    case Limit::memory: return "memory";
    case Limit::host_memory: return "host memory";
    case Limit::capacity: return "capacity of the device";
  }
  return "";
}

void AdmissionControl::set_limits(const NodeLimits& node, std::vector<TenantLimits> tenants) {
  node_ = node;
  limits_ = std::move(tenants);
  of_tenant_.resize(std::max(of_tenant_.size(), limits_.size()));
}

uint64_t AdmissionControl::host_bytes_reserved_for_others(TenantId tenant) const {
  uint64_t reserved = 0;
  for (uint32_t id = 0; id < limits_.size(); ++id) {
    const uint64_t own = limits_[id].reserved_host_bytes, used = of_tenant_[id].host_bytes;
    if (TenantId{id} != tenant && used < own) reserved += own - used;
  }
  return reserved;
}

std::optional<Limit> AdmissionControl::obstacle(TenantId tenant, const Demand& demand,
                                                const CostModel& model) const {
  const TenantLimits& most = limits_[tenant.value];
  const Booking more = booking_of(demand, model);
  Booking sum = of_tenant_[tenant.value], all = all_;
  add(sum, more, +1);
  add(all, more, +1);
  const bool too_wide = most.width > 0 && demand.width > most.width;
  const bool too_high = most.height > 0 && demand.height > most.height;
  if (too_wide || too_high) return Limit::size;
  if (beyond(sum.memory_bytes, most.memory_bytes)) return Limit::memory;
  if (beyond(sum.host_bytes, most.host_bytes)) return Limit::host_memory;
  if (sum.host_bytes > most.reserved_host_bytes &&
      beyond(all.host_bytes + host_bytes_reserved_for_others(tenant), node_.host_bytes)) {
    return Limit::host_memory;
  }
  if (demand.rate_hz <= 0) return std::nullopt;
  if (beyond(sum.buffers_per_second, most.buffers_per_second)) return Limit::buffers;
  if (beyond(sum.bits_per_second, most.bits_per_second)) return Limit::bits;
  if (beyond(sum.bytes_per_second, most.bytes_per_second)) return Limit::bytes;
  if (beyond(sum.load, most.gpu_share)) return Limit::gpu_share;
  if (beyond(all.load, node_.capacity)) return Limit::capacity;
  return std::nullopt;
}

std::variant<Booking, AdmissionRejection> AdmissionControl::book(TenantId tenant, const Demand& demand,
                                                                 const CostModel& model) {
  const auto limit = obstacle(tenant, demand, model);
  if (!limit) {
    const Booking booking = booking_of(demand, model);
    add(of_tenant_[tenant.value], booking, +1);
    add(all_, booking, +1);
    return booking;
  }
  AdmissionRejection rejection{*limit, 0, 0, 0};
  Demand smaller = demand;
  for (int size = kSizesTried; size > 0 && rejection.fit_width == 0; --size) {
    smaller.width = scaled(demand.width, size);
    smaller.height = scaled(demand.height, size);
    if (obstacle(tenant, smaller, model)) continue;
    rejection.fit_width = smaller.width;
    rejection.fit_height = smaller.height;
  }
  rejection.fit_rate_hz = fitting_rate(tenant, demand, model);
  return rejection;
}

// By bisection, as a lower rate takes no more of anything.
double AdmissionControl::fitting_rate(TenantId tenant, Demand demand, const CostModel& model) const {
  double fits = 0, too_fast = std::floor(std::min(demand.rate_hz, kMostRate)) + 1;
  while (too_fast - fits > 1) {
    demand.rate_hz = std::floor((fits + too_fast) / 2);
    (obstacle(tenant, demand, model) ? too_fast : fits) = demand.rate_hz;
  }
  return fits;
}

void AdmissionControl::release(TenantId tenant, const Booking& booking) {
  add(of_tenant_[tenant.value], booking, -1);
  add(all_, booking, -1);
}

}  // namespace gnomon::scheduler
