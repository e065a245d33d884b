// Converts a grant to a record of the session store and back. No sockets, no state.
#pragma once

#include <string>
#include <variant>

#include "daemon/config/tenant_directory.h"
#include "daemon/session/handshake.h"
#include "daemon/session/session_store.h"

namespace gnomon::daemon {

// What a session's record holds beside the grant.
struct SessionKeys {
  protocol::Bytes16 scene_hash{};  // of the scene's content when the session was opened
  protocol::Secret resumption{};   // the client has to prove that it knows this secret
  protocol::SealState seal;
};

// `tenant`: the name of the grant's tenant; ids do not outlive a process.
SessionRecord record_of(SessionId id, const SessionGrant& grant, const std::string& tenant,
                        const SessionKeys& keys);

// What the record's session was granted, if it would be granted now. The record is untrusted: a previous process may
// have written it. Every field is validated.
std::variant<SessionGrant, protocol::Refused> grant_of(const SessionRecord& record,
                                                       const TenantDirectory& directory, const Config& config,
                                                       const FindScene& find_scene);

}  // namespace gnomon::daemon
