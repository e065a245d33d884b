// Compares what a Hello asks for with what this server offers. No sockets, no state.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <variant>

#include "common/ids.h"
#include "daemon/config/config.h"
#include "daemon/frame/grant.h"
#include "protocol/messages.h"

namespace gnomon::daemon {

// Every Hello fits into this; a longer message of a client is refused before it is read.
inline constexpr size_t kMaxClientMessageBytes = 16 * 1024;

// Returns the server's name of the scene that a client asks for, an empty string if there is none.
using FindScene = std::function<std::string(const std::string& asked)>;

// Returns nullopt if the client speaks our version, so that the rest of its Hello could be read.
std::optional<protocol::Refused> check_version(const protocol::Hello& hello);

// What the Hello is granted, or why it is refused. The grant's scene id and lights are set when
// the scene is resident. `tenant`: who the client has turned out to be.
std::variant<SessionGrant, protocol::Refused> check_hello(const protocol::Hello& hello, TenantId tenant,
                                                          const Config& config, const FindScene& find_scene);

protocol::Refused refusal(protocol::RefusalCode code, std::string text);

}  // namespace gnomon::daemon
