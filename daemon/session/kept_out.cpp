#include "daemon/session/kept_out.h"

#include "daemon/session/handshake.h"

namespace gnomon::daemon {

void KeptOut::keep(TenantId tenant, const ClientNetwork& from, const std::string& why, TimePoint until) {
  std::lock_guard lock(mutex_);
  bans_.insert_or_assign({tenant.value, from}, Ban{until, why});
}

std::optional<protocol::Refused> KeptOut::objection(TenantId tenant, const ClientNetwork& from, TimePoint now) {
  std::lock_guard lock(mutex_);
  std::erase_if(bans_, [&](const auto& entry) { return entry.second.until <= now; });
  const auto found = bans_.find({tenant.value, from});
  if (found == bans_.end()) return std::nullopt;
  const auto left = std::chrono::ceil<std::chrono::seconds>(found->second.until - now);
  return refusal(protocol::RefusalCode::kept_out,
                 "kept out for another " + std::to_string(left.count()) + " s: " + found->second.why);
}

}  // namespace gnomon::daemon
