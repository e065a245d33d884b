// What the scenes occupy together and for each tenant, and which of them leave for another one. Pure: no thread, no
// lock, no clock.
//
// A scene counts with what it is predicted to need on the host and on a device, light buffers included, for whoever
// asked for it first. The operator's scenes count too, and stay.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "common/ids.h"
#include "common/result.h"

namespace gnomon::daemon {

// nullopt: the operator.
using SceneAsker = std::optional<TenantId>;

struct SceneMemoryLimits {
  uint64_t all_bytes = 0;           // 0: no limit
  std::vector<uint64_t> of_tenant;  // bytes, by TenantId; 0: half of all_bytes
};

class SceneAccount {
 public:
  void set_limits(SceneMemoryLimits limits) { limits_ = std::move(limits); }
  const SceneMemoryLimits& limits() const { return limits_; }

  void add(const std::string& name, SceneAsker asker, uint64_t bytes) { scenes_[name] = {asker, bytes, ++now_}; }
  void remove(const std::string& name) { scenes_.erase(name); }
  // What is kept beside a scene that is here. It may take the account beyond its limits until others leave.
  void grow(const std::string& name, uint64_t bytes) {
    if (const auto found = scenes_.find(name); found != scenes_.end()) found->second.bytes += bytes;
  }
  void used(const std::string& name) {
    if (const auto found = scenes_.find(name); found != scenes_.end()) found->second.last_use = ++now_;
  }
  uint64_t bytes() const;                            // of all
  uint64_t bytes_of(const std::string& name) const;  // 0 if it is not here

  // The largest scene that make_room() would find room for now. UINT64_MAX: any.
  template <class IsFree>
  uint64_t largest(SceneAsker asker, IsFree is_free) const {
    uint64_t freed = 0, own_freed = 0;
    for (const auto& [name, scene] : scenes_) {
      if (!may_leave(scene) || !is_free(name)) continue;
      freed += scene.bytes;
      if (scene.asker == asker) own_freed += scene.bytes;
    }
    return room(asker, freed, own_freed);
  }

  // The scenes that have to leave before one of `bytes` may come: of those for which `is_free` returns true the least
  // recently used, a tenant's own first where its own limit asks for it. Error: it would not fit then either; says how
  // large a scene would.
  template <class IsFree>
  Result<std::vector<std::string>> make_room(SceneAsker asker, uint64_t bytes, IsFree is_free) const {
    const uint64_t most = largest(asker, is_free);
    if (bytes > most) return too_large(bytes, most);
    std::map<uint64_t, std::string> oldest_first;
    for (const auto& [name, scene] : scenes_) {
      if (may_leave(scene) && is_free(name)) oldest_first.emplace(scene.last_use, name);
    }
    std::vector<std::string> leaving;
    uint64_t freed = 0, own_freed = 0;
    for (const bool own_alone : {true, false}) {
      for (const auto& [last_use, name] : oldest_first) {
        const Entry& scene = scenes_.at(name);
        const bool own = scene.asker == asker;
        if (own != own_alone) continue;
        const bool enough =
            own_alone ? own_room(asker, own_freed) >= bytes : room(asker, freed, own_freed) >= bytes;
        if (enough) continue;
        leaving.push_back(name);
        freed += scene.bytes;
        if (own) own_freed += scene.bytes;
      }
    }
    return leaving;
  }

 private:
  struct Entry {
    SceneAsker asker;
    uint64_t bytes = 0;
    uint64_t last_use = 0;
  };

  static bool may_leave(const Entry& scene) { return scene.asker.has_value(); }
  uint64_t own_room(SceneAsker asker, uint64_t freed) const;
  uint64_t room(SceneAsker asker, uint64_t freed, uint64_t own_freed) const;
  static Error too_large(uint64_t bytes, uint64_t most);

  SceneMemoryLimits limits_;
  std::map<std::string, Entry> scenes_;
  uint64_t now_ = 0;  // counts uses
};

}  // namespace gnomon::daemon
