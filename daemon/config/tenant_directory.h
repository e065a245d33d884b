// The tenants by id, across all reloads. A tenant is identified by its name. A tenant that the configuration no longer
// names is closed but keeps its id, so that no other tenant gets it; a tenant that is named again is open again.
//
// An immutable value: the main thread makes the next one and publishes it, other threads read it.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "common/ids.h"
#include "daemon/config/config.h"

namespace gnomon::daemon {

// Most tenants, open or closed, of one process: the metrics reserve room for them.
inline constexpr size_t kMostTenants = 4096;

class TenantDirectory {
 public:
  // Returns the next directory, in which `tenants` are the open ones.
  TenantDirectory with(const std::vector<TenantConfig>& tenants) const;

  // Finds an open tenant; nullopt if there is none of that name.
  std::optional<TenantId> find(std::string_view name) const;
  bool open(TenantId id) const { return entries_[id.value].open; }
  const TenantConfig& config(TenantId id) const { return entries_[id.value].config; }
  const std::string& name(TenantId id) const { return entries_[id.value].config.name; }
  size_t size() const { return entries_.size(); }

  // By id; closed tenants with their last configuration.
  std::vector<TenantConfig> configs() const;

 private:
  struct Entry {
    TenantConfig config;
    bool open = true;
  };

  std::vector<Entry> entries_;
};

}  // namespace gnomon::daemon
