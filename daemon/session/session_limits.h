// Limits the number of sessions in all, of a tenant and from an address, and what a tenant's sessions may ask for
// together. A permit counts as a session while it exists.
//
// Half of all places are reserved, equal parts for the tenants. A tenant without a limit of its own may take any place
// beyond its reserve that is not reserved for another tenant: alone it gets most of the node, and however many sessions
// the others have, a tenant finds its reserve free. The memory that sessions can make the host keep is shared alike.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "common/ids.h"
#include "daemon/config/config.h"
#include "daemon/config/tenant_directory.h"
#include "daemon/session/client_network.h"
#include "protocol/messages.h"
#include "scheduler/admission_control.h"

namespace gnomon::daemon {

class SessionLimits;

// Move-only; any thread may drop it. Outlived by its SessionLimits.
class SessionPermit {
 public:
  SessionPermit(SessionLimits& limits, TenantId tenant, const ClientNetwork& network)
      : limits_(&limits), tenant_(tenant), network_(network) {}
  SessionPermit(SessionPermit&& other) noexcept
      : limits_(std::exchange(other.limits_, nullptr)),
        tenant_(other.tenant_),
        network_(other.network_),
        booking_(other.booking_) {}
  SessionPermit& operator=(SessionPermit&&) = delete;
  ~SessionPermit();

  const ClientNetwork& network() const { return network_; }

 private:
  friend class SessionLimits;

  SessionLimits* limits_;
  TenantId tenant_;
  ClientNetwork network_;
  std::optional<scheduler::Booking> booking_;
};

// The account of the host memory that sessions may come to need; bytes.
struct SessionMemory {
  uint64_t bytes = 0;
  uint64_t limit_bytes = 0;
  std::vector<uint64_t> of_tenant = {};  // by TenantId
};

// Any thread.
class SessionLimits {
 public:
  // `devices`: the number of devices whose time can be booked.
  explicit SessionLimits(const Config& config, size_t devices = 1);

  // Returns a permit, or the refusal that names the limit that is reached.
  std::variant<SessionPermit, protocol::Refused> take(TenantId tenant, const ClientNetwork& from);

  // Books what the session asks for on its permit. Returns nullopt, or the exceeded limit and what would fit.
  std::optional<scheduler::AdmissionRejection> book(SessionPermit& permit, const scheduler::Demand& demand,
                                                    const scheduler::CostModel& model);

  // The limits of `config` and of the tenants hold from now on. Permits that were given out stay valid.
  void set_limits(const Config& config, const TenantDirectory& tenants);

  uint32_t taken() const;  // the number of permits that exist
  SessionMemory memory() const;

 private:
  friend class SessionPermit;
  void give_back(const SessionPermit& permit);
  std::optional<protocol::Refused> obstacle(TenantId tenant, const ClientNetwork& from) const;
  uint32_t reserved_for_others(TenantId tenant) const;

  const double devices_;
  mutable std::mutex mutex_;  // guards what follows
  uint32_t max_all_ = 0;
  uint32_t max_per_address_ = 0;
  struct Places {
    uint32_t taken = 0;
    uint32_t reserved = 0;             // places that others leave free for it, as long as it has fewer
    std::optional<uint32_t> most = 0;  // 0: no limit; nullopt: what is not reserved for others
  };
  std::vector<Places> of_tenant_;  // by id
  scheduler::AdmissionControl admission_;
  uint64_t host_limit_bytes_ = 0;
  uint32_t all_ = 0;
  std::map<ClientNetwork, uint32_t> of_network_;
};

}  // namespace gnomon::daemon
