// The tenants by id, through all reloads: a tenant is its name. One that the configuration names no more keeps its id,
// so that nobody else gets it, and is closed; one that is named again is open again.
//
// A value: the main thread makes the next one and publishes it, the others look at it.
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "common/ids.h"
#include "daemon/config/config.h"

namespace gnomon::daemon {

// Open and closed ones, in the life of one process: what counts them is made for so many.
inline constexpr size_t kMostTenants = 4096;

class Roster {
 public:
  // `tenants` are the open ones from now on.
  Roster with(const std::vector<TenantConfig>& tenants) const;

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
