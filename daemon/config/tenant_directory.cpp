#include "daemon/config/tenant_directory.h"

#include <algorithm>

namespace gnomon::daemon {

TenantDirectory TenantDirectory::with(const std::vector<TenantConfig>& tenants) const {
  TenantDirectory next = *this;
  for (Entry& entry : next.entries_) entry.open = false;
  for (const TenantConfig& tenant : tenants) {
    const auto known = std::find_if(next.entries_.begin(), next.entries_.end(),
                                    [&](const Entry& entry) { return entry.config.name == tenant.name; });
    if (known == next.entries_.end()) {
      next.entries_.push_back({tenant, true});
    } else {
      *known = {tenant, true};
    }
  }
  return next;
}

std::optional<TenantId> TenantDirectory::find(std::string_view name) const {
  for (uint32_t i = 0; i < entries_.size(); ++i) {
    if (entries_[i].open && entries_[i].config.name == name) return TenantId{i};
  }
  return std::nullopt;
}

std::vector<TenantConfig> TenantDirectory::configs() const {
  std::vector<TenantConfig> configs;
  for (const Entry& entry : entries_) configs.push_back(entry.config);
  return configs;
}

}  // namespace gnomon::daemon
