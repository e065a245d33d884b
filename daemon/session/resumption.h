// A session as it is kept for being resumed, and back. No sockets, no state.
#pragma once

#include <string>
#include <variant>

#include "daemon/config/roster.h"
#include "daemon/session/handshake.h"
#include "daemon/session/session_store.h"

namespace gnomon::daemon {

// `scene_hash`: of what the scene is now; `resumption`: what its client will prove that it knows.
SessionRecord record_of(SessionId id, const Accepted& accepted, const std::string& tenant,
                        const protocol::Bytes16& scene_hash, const protocol::Secret& resumption,
                        const protocol::SealState& seal);

// What was accepted then, if it would be now: nothing in the record is believed unseen, as another life wrote it.
std::variant<Accepted, protocol::Refused> accepted_of(const SessionRecord& record, const Roster& roster,
                                                      const Config& config, const FindScene& find_scene);

}  // namespace gnomon::daemon
