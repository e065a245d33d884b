#include "daemon/scenes/scene_account.h"

#include <algorithm>
#include <limits>

namespace gnomon::daemon {
namespace {

constexpr uint64_t kAny = std::numeric_limits<uint64_t>::max();

uint64_t left(uint64_t limit, uint64_t used) { return limit > used ? limit - used : 0; }

}  // namespace

uint64_t SceneAccount::bytes() const {
  uint64_t sum = 0;
  for (const auto& [name, scene] : scenes_) sum += scene.bytes;
  return sum;
}

uint64_t SceneAccount::bytes_of(const std::string& name) const {
  const auto found = scenes_.find(name);
  return found == scenes_.end() ? 0 : found->second.bytes;
}

uint64_t SceneAccount::own_room(SceneAsker asker, uint64_t freed) const {
  if (!asker || limits_.all_bytes == 0) return kAny;
  const bool has_own = asker->value < limits_.of_tenant.size() && limits_.of_tenant[asker->value] > 0;
  const uint64_t limit = has_own ? limits_.of_tenant[asker->value] : limits_.all_bytes / 2;
  uint64_t used = 0;
  for (const auto& [name, scene] : scenes_) used += scene.asker == asker ? scene.bytes : 0;
  return left(limit, used - std::min(used, freed));
}

uint64_t SceneAccount::room(SceneAsker asker, uint64_t freed, uint64_t own_freed) const {
  if (limits_.all_bytes == 0) return kAny;
  const uint64_t used = bytes();
  return std::min(own_room(asker, own_freed), left(limits_.all_bytes, used - std::min(used, freed)));
}

Error SceneAccount::too_large(uint64_t bytes, uint64_t most) {
  return Error{"it needs " + std::to_string((bytes >> 20) + 1) + " MiB of memory, and a scene may have " +
               std::to_string(most >> 20) + " MiB now"};
}

}  // namespace gnomon::daemon
