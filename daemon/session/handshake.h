// What a Hello asks for, against what this server offers. No sockets, no state.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <variant>

#include "common/ids.h"
#include "daemon/config/config.h"
#include "protocol/messages.h"

namespace gnomon::daemon {

// A Hello fits into this; longer messages of a client are refused before they are read.
inline constexpr size_t kMaxClientMessageBytes = 16 * 1024;

struct Accepted {
  TenantId tenant;
  std::string scene;  // as the server names it
  uint16_t width = 0;
  uint16_t height = 0;
  float rate_hz = 0;
  protocol::CodecId codec = protocol::CodecId::tiles_lz4;
  protocol::CodecId dense_codec = protocol::CodecId::tiles_lz4;  // where bytes are short
  protocol::CipherId cipher = protocol::CipherId::aes_128_gcm;
  uint64_t features = 0;                       // of the client's those that are known here
  std::shared_ptr<const void> scene_use = {};  // keeps the scene from being unloaded, once it was fetched
};

// The server's name of the scene that a client asks for; empty: there is none.
using FindScene = std::function<std::string(const std::string& asked)>;

// Empty: the client speaks our version, and the rest of its Hello could be read.
std::optional<protocol::Refused> check_version(const protocol::Hello& hello);

// `tenant`: who the client has turned out to be.
std::variant<Accepted, protocol::Refused> check_hello(const protocol::Hello& hello, TenantId tenant,
                                                      const Config& config, const FindScene& find_scene);

protocol::Refused refusal(protocol::RefusalCode code, std::string text);

}  // namespace gnomon::daemon
