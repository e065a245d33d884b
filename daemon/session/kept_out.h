// Clients that an operator keeps out for a time: those of one tenant at one address. A tenant's clients share its token
// or certificate, and one client may have many sessions, so that neither alone tells who was meant.
#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "common/clock.h"
#include "common/ids.h"
#include "daemon/session/client_network.h"
#include "protocol/messages.h"

namespace gnomon::daemon {

// Any thread.
class KeptOut {
 public:
  // Replaces what was said of them before. `until` has passed at once: they may come in.
  void keep(TenantId tenant, const ClientNetwork& from, const std::string& why, TimePoint until);

  // The refusal that such a client is sent, which says for how long it is kept out and why; nullopt if it may come in.
  std::optional<protocol::Refused> objection(TenantId tenant, const ClientNetwork& from, TimePoint now);

 private:
  struct Ban {
    TimePoint until;
    std::string why;
  };

  std::mutex mutex_;  // guards what follows
  std::map<std::pair<uint32_t, ClientNetwork>, Ban> bans_;
};

}  // namespace gnomon::daemon
