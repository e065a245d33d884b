// The tenants by id, through all reloads: a tenant is its name. A tenant that the configuration no longer names keeps
// its id, so that no other tenant gets it, and is closed; a tenant that is named again is open again.
//
// An immutable value: the main thread makes the next one and publishes it, other threads read it.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "common/ids.h"
#include "daemon/config/config.h"

namespace gnomon::daemon {

// Open and closed ones, while one process runs: the metrics have room for so many.
inline constexpr size_t kMostTenants = 4096;

class TenantDirectory {
 public:
  // `tenants` are the open ones from now on.
  TenantDirectory with(const std::vector<TenantConfig>& tenants) const;

  // An open one.
  std::optional<TenantId> find(std::string_view name) const;
  bool open(TenantId id) const { return entries_[id.value].open; }
  const TenantConfig& config(TenantId id) const { return entries_[id.value].config; }
  const std::string& name(TenantId id) const { return entries_[id.value].config.name; }
  size_t size() const { return entries_.size(); }

  // By id; closed ones as they were last.
  std::vector<TenantConfig> configs() const;

 private:
  struct Entry {
    TenantConfig config;
    bool open = true;
  };

  std::vector<Entry> entries_;
};

}  // namespace gnomon::daemon
