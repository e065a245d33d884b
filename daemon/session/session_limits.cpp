#include "daemon/session/session_limits.h"

#include <algorithm>

#include "daemon/config/machine_memory.h"

#include "daemon/session/handshake.h"

namespace gnomon::daemon {
namespace {

protocol::Refused full(const std::string& whose, uint32_t limit) {
  return refusal(protocol::RefusalCode::too_many_sessions,
                 whose + " has its " + std::to_string(limit) + " sessions already");
}

// The part of the machine's memory that sessions may need if the operator sets none. Scenes may have half of it.
constexpr uint64_t kUsualShareOfMemory = 4;

uint64_t session_memory_bytes(const ServerConfig& server) {
  if (server.max_session_memory_mb > 0) return uint64_t{server.max_session_memory_mb} << 20;
  static const uint64_t usable = usable_memory_bytes();
  return usable / kUsualShareOfMemory;
}

scheduler::TenantLimits limits_of(const TenantConfig& tenant, uint64_t reserved_host_bytes) {
  const uint64_t most_host_bytes = uint64_t{tenant.max_session_memory_mb} << 20;
  return {.width = tenant.max_width,
          .height = tenant.max_height,
          .buffers_per_second = double(tenant.max_vbps),
          .bits_per_second = double(tenant.max_bits_per_s),
          .bytes_per_second = double(tenant.max_bytes_per_s),
          .gpu_share = tenant.max_gpu_percent / 100.0,
          .memory_bytes = uint64_t{tenant.max_memory_mb} << 20,
          .host_bytes = most_host_bytes,
          .reserved_host_bytes =
              most_host_bytes > 0 ? std::min(most_host_bytes, reserved_host_bytes) : reserved_host_bytes};
}

}  // namespace

SessionPermit::~SessionPermit() {
  if (limits_) limits_->give_back(*this);
}

SessionLimits::SessionLimits(const Config& config, size_t devices) : devices_(static_cast<double>(devices)) {
  set_limits(config, TenantDirectory().with(config.tenants));
}

void SessionLimits::set_limits(const Config& config, const TenantDirectory& tenants) {
  const std::vector<TenantConfig> configs = tenants.configs();
  uint32_t open = 0;
  for (uint32_t id = 0; id < configs.size(); ++id) open += tenants.open(TenantId{id});
  const scheduler::NodeLimits node{.capacity = devices_ * config.scheduler.admit_percent / 100.0,
                                   .host_bytes = session_memory_bytes(config.server)};
  const uint64_t reserved_bytes = node.host_bytes / 2 / std::max(1u, open);
  std::vector<scheduler::TenantLimits> limits;
  for (uint32_t id = 0; id < configs.size(); ++id) {
    limits.push_back(limits_of(configs[id], tenants.open(TenantId{id}) ? reserved_bytes : 0));
  }
  std::lock_guard lock(mutex_);
  max_all_ = config.server.max_sessions;
  max_per_address_ = config.server.max_sessions_per_address;
  of_tenant_.resize(configs.size());
  const uint32_t reserve = max_all_ / 2 / std::max(1u, open);
  for (uint32_t id = 0; id < configs.size(); ++id) {
    Places& places = of_tenant_[id];
    places.most = configs[id].max_sessions;
    const bool limited = places.most.value_or(0) > 0;
    places.reserved = !tenants.open(TenantId{id}) ? 0 : limited ? std::min(reserve, *places.most) : reserve;
  }
  host_limit_bytes_ = node.host_bytes;
  admission_.set_limits(node, std::move(limits));
}

uint32_t SessionLimits::reserved_for_others(TenantId tenant) const {
  uint32_t reserved = 0;
  for (uint32_t id = 0; id < of_tenant_.size(); ++id) {
    const Places& places = of_tenant_[id];
    if (TenantId{id} != tenant && places.taken < places.reserved) reserved += places.reserved - places.taken;
  }
  return reserved;
}

std::optional<protocol::Refused> SessionLimits::obstacle(TenantId tenant, const ClientNetwork& from) const {
  const Places& own = of_tenant_[tenant.value];
  if (all_ >= max_all_) return full("the server", max_all_);
  if (own.most.value_or(0) > 0 && own.taken >= *own.most) return full("the tenant", *own.most);
  if (!own.most && own.taken >= own.reserved && all_ + reserved_for_others(tenant) >= max_all_) {
    return refusal(protocol::RefusalCode::too_many_sessions,
                   "the tenant has " + std::to_string(own.taken) + " sessions, and what is left is for others");
  }
  const auto here = of_network_.find(from);
  if (here != of_network_.end() && here->second >= max_per_address_) return full("your address", max_per_address_);
  return std::nullopt;
}

std::variant<SessionPermit, protocol::Refused> SessionLimits::take(TenantId tenant, const ClientNetwork& from) {
  std::lock_guard lock(mutex_);
  if (auto refused = obstacle(tenant, from)) return *std::move(refused);
  ++all_;
  ++of_tenant_[tenant.value].taken;
  ++of_network_[from];
  return SessionPermit(*this, tenant, from);
}

std::optional<scheduler::AdmissionRejection> SessionLimits::book(SessionPermit& permit,
                                                                 const scheduler::Demand& demand,
                                                                 const scheduler::CostModel& model) {
  std::lock_guard lock(mutex_);
  const auto verdict = admission_.book(permit.tenant_, demand, model);
  if (const auto* rejection = std::get_if<scheduler::AdmissionRejection>(&verdict)) return *rejection;
  permit.booking_ = std::get<scheduler::Booking>(verdict);
  return std::nullopt;
}

void SessionLimits::give_back(const SessionPermit& permit) {
  std::lock_guard lock(mutex_);
  --all_;
  --of_tenant_[permit.tenant_.value].taken;
  if (permit.booking_) admission_.release(permit.tenant_, *permit.booking_);
  const auto here = of_network_.find(permit.network_);
  if (--here->second == 0) of_network_.erase(here);
}

SessionMemory SessionLimits::memory() const {
  std::lock_guard lock(mutex_);
  SessionMemory memory{.bytes = admission_.host_bytes(), .limit_bytes = host_limit_bytes_};
  for (uint32_t id = 0; id < of_tenant_.size(); ++id) {
    memory.of_tenant.push_back(admission_.host_bytes(TenantId{id}));
  }
  return memory;
}

uint32_t SessionLimits::taken() const {
  std::lock_guard lock(mutex_);
  return all_;
}

}  // namespace gnomon::daemon
