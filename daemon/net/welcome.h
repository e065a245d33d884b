// What a client is granted by the scene that it asks for, and the message that says so.
#pragma once

#include <cstdint>
#include <vector>

#include "daemon/net/net_shared.h"
#include "daemon/session/session.h"
#include "protocol/messages.h"
#include "scenes/registry.h"

namespace gnomon::daemon {

// Completes a grant by what the scene's lights are, and its tenant may have. Without area lights there is nothing to
// sample.
void complete(SessionGrant& grant, const std::vector<scenes::Light>& lights, SampleCounts most);

struct ServingPorts {
  uint16_t data = 0;     // UDP
  uint16_t control = 0;  // TCP, which the client has reached
};

protocol::Welcome welcome_of(const Session& session, const scenes::LoadedScene& scene, const NetShared& shared,
                             ServingPorts ports);

}  // namespace gnomon::daemon
