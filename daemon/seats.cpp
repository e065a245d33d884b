#include "daemon/seats.h"

namespace gnomon::daemon {
namespace {

protocol::Refused full(const std::string& whose, uint32_t limit) {
  protocol::Refused refused;
  refused.code = protocol::RefusalCode::too_many_sessions;
  refused.text = whose + " has its " + std::to_string(limit) + " sessions already";
  return refused;
}

}  // namespace

Seat::~Seat() {
  if (seats_) seats_->give_back(tenant_, address_);
}

Seats::Seats(const Config& config)
    : max_all_(config.server.max_sessions),
      max_per_address_(config.server.max_sessions_per_address),
      of_tenant_(config.tenants.size()) {
  for (const TenantConfig& tenant : config.tenants) max_of_tenant_.push_back(tenant.max_sessions);
}

std::variant<Seat, protocol::Refused> Seats::take(TenantId tenant, const asio::ip::address& address) {
  std::lock_guard lock(mutex_);
  const uint32_t tenant_limit = max_of_tenant_[tenant.value];
  if (all_ >= max_all_) return full("the server", max_all_);
  if (tenant_limit != 0 && of_tenant_[tenant.value] >= tenant_limit) return full("the tenant", tenant_limit);
  const auto here = of_address_.find(address);
  if (here != of_address_.end() && here->second >= max_per_address_) return full("your address", max_per_address_);
  ++all_;
  ++of_tenant_[tenant.value];
  ++of_address_[address];
  return Seat(*this, tenant, address);
}

void Seats::give_back(TenantId tenant, const asio::ip::address& address) {
  std::lock_guard lock(mutex_);
  --all_;
  --of_tenant_[tenant.value];
  const auto here = of_address_.find(address);
  if (--here->second == 0) of_address_.erase(here);
}

uint32_t Seats::taken() const {
  std::lock_guard lock(mutex_);
  return all_;
}

}  // namespace gnomon::daemon
