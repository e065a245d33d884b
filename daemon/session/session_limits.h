// Limits the number of sessions in all, of a tenant and from an address, and what a tenant's sessions may ask for
// together. A permit counts as a session while it exists.
#pragma once

#include <asio/ip/address.hpp>

#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "common/ids.h"
#include "daemon/config/config.h"
#include "protocol/messages.h"
#include "scheduler/admission_control.h"

namespace gnomon::daemon {

class SessionLimits;

// Move-only; any thread may drop it. Outlived by its SessionLimits.
class SessionPermit {
 public:
  SessionPermit(SessionLimits& limits, TenantId tenant, asio::ip::address address)
      : limits_(&limits), tenant_(tenant), address_(std::move(address)) {}
  SessionPermit(SessionPermit&& other) noexcept
      : limits_(std::exchange(other.limits_, nullptr)),
        tenant_(other.tenant_),
        address_(other.address_),
        booking_(other.booking_) {}
  SessionPermit& operator=(SessionPermit&&) = delete;
  ~SessionPermit();

 private:
  friend class SessionLimits;

  SessionLimits* limits_;
  TenantId tenant_;
  asio::ip::address address_;
  std::optional<scheduler::Booking> booking_;
};

// Any thread.
class SessionLimits {
 public:
  // `devices`: the number of devices whose time can be booked.
  explicit SessionLimits(const Config& config, size_t devices = 1);

  // Returns a permit, or the refusal that names the limit that is reached.
  std::variant<SessionPermit, protocol::Refused> take(TenantId tenant, const asio::ip::address& address);

  // Books what the session asks for on its permit. Returns nullopt, or the exceeded limit and what would fit.
  std::optional<scheduler::AdmissionRejection> book(SessionPermit& permit, const scheduler::Demand& demand,
                                                    const scheduler::CostModel& model);

  // The limits of `config`, which lists tenants by id, hold from now on. Permits that were given out stay valid.
  void set_limits(const Config& config);

  uint32_t taken() const;  // the number of permits that exist

 private:
  friend class SessionPermit;
  void give_back(const SessionPermit& permit);

  const double devices_;
  mutable std::mutex mutex_;  // guards what follows
  uint32_t max_all_ = 0;
  uint32_t max_per_address_ = 0;
  std::vector<uint32_t> max_of_tenant_;  // 0: no limit
  scheduler::AdmissionControl admission_;
  uint32_t all_ = 0;
  std::vector<uint32_t> of_tenant_;
  std::map<asio::ip::address, uint32_t> of_address_;
};

}  // namespace gnomon::daemon
