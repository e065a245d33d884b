// Control messages: what client and server say over the stream connection. WIRE.md has the byte tables.
//
// Decoding is total: any bytes give a message or an error, and nothing is allocated beyond the message's own size.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "common/result.h"
#include "protocol/datagram.h"
#include "protocol/types.h"

namespace gnomon::protocol {

// The protocol's name within TLS (RFC 7301), as its lists have it: length, then letters. A server of something else
// that shares a certificate with ours cannot be made to listen to a client of ours, nor the other way round.
inline constexpr std::array<uint8_t, 7> kAlpn{6, 'g', 'n', 'o', 'm', 'o', 'n'};

struct Hello {
  uint16_t version_min = kVersion;
  uint16_t version_max = kVersion;
  uint64_t features = 0;          // unknown bits are ignored
  std::string client;             // program and version, for the log
  std::string tenant;             // empty: the default tenant
  std::string token;              // the tenant's secret
  std::vector<CipherId> ciphers;  // of the data channel, in order of preference; empty: the server's choice
  std::string scene;
  uint16_t width = 0;  // pixels of the traced buffer, border included
  uint16_t height = 0;
  uint16_t border_x = 0;  // of these, prediction border: pixels in all, left and right together
  uint16_t border_y = 0;
  float rate_hz = 0;                // views a second that the client means to ask for; 0: as many as it gets
  std::vector<CodecId> codecs;      // in order of preference; empty: the server's default
  std::vector<std::string> passes;  // render passes in order; empty: the server's default
  friend bool operator==(const Hello&, const Hello&) = default;
};

struct Welcome {
  uint16_t version = kVersion;
  uint64_t features = 0;
  SessionId session;
  uint16_t data_port = 0;                   // UDP, same address as the control connection
  CipherId cipher = CipherId::aes_128_gcm;  // of the data channel's seal (protocol/seal.h)
  uint16_t width = 0;
  uint16_t height = 0;
  float rate_hz = 0;
  CodecId codec = CodecId::tiles_lz4;
  std::vector<std::string> passes;
  std::string tracer;
  uint32_t silence_timeout_ms = 0;  // a session silent for this long is closed
  SceneManifest scene;
  // On the wire with kFeatureMoments:
  uint32_t lights_version = 0;      // of the manifest's lights
  std::vector<NodeMotion> motions;  // beside the animations of the scene's file
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

// The codes are part of the protocol: never renumbered.
enum class RefusalCode : uint16_t {
  malformed = 1,
  version = 2,
  unknown_tenant = 3,
  bad_token = 4,
  unknown_scene = 5,
  scene_unavailable = 6,
  bad_size = 7,
  too_many_sessions = 8,
  over_capacity = 9,
  unknown_pass = 10,
  draining = 11,
  internal = 12,
  unknown_session = 13,
};
const char* to_string(RefusalCode code);

struct Refused {
  RefusalCode code = RefusalCode::internal;
  std::string text;  // for a person
  // What would have been accepted instead; 0: nothing of that kind is on offer.
  uint16_t fit_width = 0;
  uint16_t fit_height = 0;
  float fit_rate_hz = 0;
  friend bool operator==(const Refused&, const Refused&) = default;
};

struct SceneChanged {
  SceneManifest scene;
  friend bool operator==(const SceneChanged&, const SceneChanged&) = default;
};

struct LightsChanged {
  std::vector<LightInfo> lights;
  uint32_t version = 0;  // which frames are of these lights; counts up
  friend bool operator==(const LightsChanged&, const LightsChanged&) = default;
};

struct Degraded {
  uint16_t width = 0;
  uint16_t height = 0;
  float rate_hz = 0;
  std::string reason;
  std::vector<uint16_t> untraced_lights = {};  // their masks are lit everywhere
  friend bool operator==(const Degraded&, const Degraded&) = default;
};

struct Draining {
  uint32_t deadline_ms = 0;
  friend bool operator==(const Draining&, const Draining&) = default;
};

// Server to client, about once a second.
struct Stats {
  uint64_t frames = 0;     // answered in this session
  uint64_t coalesced = 0;  // views replaced by a newer one before they were rendered
  uint32_t queue_us = 0;   // means over the last second
  uint32_t gpu_us = 0;
  uint32_t total_us = 0;
  friend bool operator==(const Stats&, const Stats&) = default;
};

// Either side, before it closes on purpose.
struct Bye {
  std::string reason;
  friend bool operator==(const Bye&, const Bye&) = default;
};

// What a datagram would carry, where no datagrams pass. Either side.
struct Data {
  DatagramKind kind = DatagramKind::camera_update;
  uint64_t sequence = 0;      // the server's: out of the same count as its datagrams
  std::vector<uint8_t> body;  // up to kMaxDataBytes
  friend bool operator==(const Data&, const Data&) = default;
};
inline constexpr size_t kMaxDataBytes = 16'000;

// In the place of a Hello: the session goes on with this connection, as the same Welcome with what holds now says.
struct Resume {
  SessionId session;
  Bytes32 proof{};  // resumption_proof (protocol/seal_exporter.h)
  friend bool operator==(const Resume&, const Resume&) = default;
};

using Message = std::variant<Hello, Welcome, Refused, SceneChanged, LightsChanged, Degraded, Draining, Stats, Bye,
                             Data, Resume>;

// The whole frame: length, type, body. Texts and lists longer than WIRE.md allows are cut to what it allows, and
// bytes of a text that are not UTF-8 or control characters become '?'. Other values are the caller's promise.
std::vector<uint8_t> encode(const Message& message);

// Takes frames out of a byte stream. Feed it what arrived; take messages until there is none.
class MessageReader {
 public:
  // `max_bytes`: the longest frame accepted (a server takes small ones before a Hello has been checked).
  explicit MessageReader(size_t max_bytes = kMaxControlBytes) : max_bytes_(max_bytes) {}

  void feed(std::span<const uint8_t> bytes);

  // Nothing yet: an empty optional. Unknown types are skipped. An error is final: close the connection.
  Result<std::optional<Message>> next();

 private:
  Error fail(std::string why);

  size_t max_bytes_;
  std::vector<uint8_t> buffer_;
  size_t read_ = 0;  // bytes of buffer_ that are done with
  std::optional<Error> failed_;
};

}  // namespace gnomon::protocol
