#include "daemon/session/session_limits.h"

#include <algorithm>

namespace gnomon::daemon {
namespace {

protocol::Refused full(const std::string& whose, uint32_t limit) {
  protocol::Refused refused;
  refused.code = protocol::RefusalCode::too_many_sessions;
  refused.text = whose + " has its " + std::to_string(limit) + " sessions already";
  return refused;
}

// `sessions` is 0, no limit: sessions are counted when a permit is taken, before the scene is brought.
scheduler::TenantLimits limits_of(const TenantConfig& tenant) {
  return {.sessions = 0,
          .width = tenant.max_width,
          .height = tenant.max_height,
          .buffers_per_second = double(tenant.max_vbps),
          .bits_per_second = double(tenant.max_bits_per_s),
          .bytes_per_second = double(tenant.max_bytes_per_s),
          .gpu_share = tenant.max_gpu_percent / 100.0,
          .memory_bytes = uint64_t{tenant.max_memory_mb} << 20};
}

}  // namespace

SessionPermit::~SessionPermit() {
  if (limits_) limits_->give_back(*this);
}

SessionLimits::SessionLimits(const Config& config, size_t devices) : devices_(static_cast<double>(devices)) {
  set_limits(config);
}

void SessionLimits::set_limits(const Config& config) {
  std::vector<scheduler::TenantLimits> limits;
  for (const TenantConfig& tenant : config.tenants) limits.push_back(limits_of(tenant));
  std::lock_guard lock(mutex_);
  max_all_ = config.server.max_sessions;
  max_per_address_ = config.server.max_sessions_per_address;
  of_tenant_.resize(std::max(of_tenant_.size(), config.tenants.size()));
  max_of_tenant_.clear();
  for (const TenantConfig& tenant : config.tenants) max_of_tenant_.push_back(tenant.max_sessions);
  admission_.set_limits(devices_ * config.scheduler.admit_percent / 100.0, std::move(limits));
}

std::variant<SessionPermit, protocol::Refused> SessionLimits::take(TenantId tenant,
                                                                   const asio::ip::address& address) {
  std::lock_guard lock(mutex_);
  const uint32_t tenant_limit = max_of_tenant_[tenant.value];
  if (all_ >= max_all_) return full("the server", max_all_);
  if (tenant_limit != 0 && of_tenant_[tenant.value] >= tenant_limit) return full("the tenant", tenant_limit);
  const auto here = of_address_.find(address);
  if (here != of_address_.end() && here->second >= max_per_address_) return full("your address", max_per_address_);
  ++all_;
  ++of_tenant_[tenant.value];
  ++of_address_[address];
  return SessionPermit(*this, tenant, address);
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
  --of_tenant_[permit.tenant_.value];
  if (permit.booking_) admission_.release(permit.tenant_, *permit.booking_);
  const auto here = of_address_.find(permit.address_);
  if (--here->second == 0) of_address_.erase(here);
}

uint32_t SessionLimits::taken() const {
  std::lock_guard lock(mutex_);
  return all_;
}

}  // namespace gnomon::daemon
