// Control messages, which client and server exchange over the TLS connection. WIRE.md has the byte tables.
//
// Decoding is total: any bytes give a message or an error. Memory is allocated in proportion to the message's size.
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

// The protocol's ALPN identifier (RFC 7301) in wire form: length, then characters. It prevents cross-protocol attacks:
// a server of another protocol that shares a certificate with ours does not accept our clients, nor the reverse.
inline constexpr std::array<uint8_t, 7> kAlpn{6, 'g', 'n', 'o', 'm', 'o', 'n'};

// The most bytes of a name, a token and a scene's name. What is written is cut to them.
inline constexpr size_t kMaxName = 256, kMaxToken = 512, kMaxScene = 1024;

struct Hello {
  uint16_t version_min = kVersion;
  uint16_t version_max = kVersion;
  uint64_t features = 0;          // unknown bits are ignored
  std::string client;             // program and version, for the log
  std::string tenant;             // if empty, the default tenant
  std::string token;              // the tenant's secret
  std::vector<CipherId> ciphers;  // of the data channel, in order of preference; if empty, the server's choice
  std::string scene;
  uint16_t width = 0;  // pixels of the traced buffer, border included
  uint16_t height = 0;
  uint16_t border_x = 0;  // pixels of the width that are prediction border, left and right together
  uint16_t border_y = 0;
  float rate_hz = 0;                // views a second that the client means to ask for; 0: as many as it gets
  std::vector<CodecId> codecs;      // in order of preference; if empty, the server's default
  std::vector<std::string> passes;  // render passes in order; if empty, the server's default
  uint8_t samples = 0;              // wanted at most, as to_byte(SampleCounts); 0: 1; on the wire with kFeatureSoft
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
  // On the wire with kFeatureFleet. Numeric addresses; whoever uses them finds out whether they are.
  std::string data_host;  // where datagrams go, in the place of the control connection's address
  std::string home_host;  // where this server itself takes connections
  uint16_t home_port = 0;
  // On the wire with kFeatureSoft:
  uint8_t samples = 1;          // granted, as to_byte(SampleCounts)
  std::vector<AreaInfo> areas;  // of the scene's lights, one for each of them
  friend bool operator==(const Welcome&, const Welcome&) = default;
};

// The codes are part of the protocol and are never renumbered.
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
  kept_out = 14,
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
  // On the wire with kFeatureSoft, as in Welcome; 0: not on the wire.
  uint8_t samples = 0;
  std::vector<AreaInfo> areas = {};
  friend bool operator==(const SceneChanged&, const SceneChanged&) = default;
};

struct LightsChanged {
  std::vector<LightInfo> lights;
  uint32_t version = 0;  // Moment::lights_version of frames with these lights; counts up
  friend bool operator==(const LightsChanged&, const LightsChanged&) = default;
};

struct Degraded {
  uint16_t width = 0;
  uint16_t height = 0;
  float rate_hz = 0;
  std::string reason;
  std::vector<uint16_t> untraced_lights = {};  // their masks are lit everywhere
  uint8_t samples = 0;  // from now on, as to_byte(SampleCounts); on the wire with kFeatureSoft; 0: not on the wire
  friend bool operator==(const Degraded&, const Degraded&) = default;
};

struct Draining {
  static constexpr uint32_t kNoDeadline = 0xffff'ffff;
  static constexpr uint8_t kMoveNow = 1;  // with kFeatureFleet: the fleet's door is to be asked for another session

  uint32_t deadline_ms = 0;  // or kNoDeadline
  uint8_t flags = 0;         // a Draining of before this field has none
  bool move_now() const { return (flags & kMoveNow) != 0; }
  friend bool operator==(const Draining&, const Draining&) = default;
};

// Sent by the server about once a second.
struct Stats {
  uint64_t frames = 0;     // answered in this session
  uint64_t coalesced = 0;  // views replaced by a newer one before they were rendered
  uint32_t queue_us = 0;   // means over the last second
  uint32_t gpu_us = 0;
  uint32_t total_us = 0;
  friend bool operator==(const Stats&, const Stats&) = default;
};

// Sent by either side before it closes the connection on purpose.
struct Bye {
  std::string reason;
  // The server's: so long it takes no session of this client, who therefore does not come back by itself. 0: it may. A
  // Bye of before this field has none.
  uint32_t stay_out_ms = 0;
  friend bool operator==(const Bye&, const Bye&) = default;
};

// A camera update or feedback of the client, a slice or parity of the server, on paths that let no datagrams pass.
struct Data {
  DatagramKind kind = DatagramKind::camera_update;
  uint64_t sequence = 0;      // the server's: counted together with its datagrams; the client's: any
  std::vector<uint8_t> body;  // up to kMaxDataBytes
  friend bool operator==(const Data&, const Data&) = default;
};
inline constexpr size_t kMaxDataBytes = 16'000;

// Sent instead of Hello to continue a session on this connection. A Welcome of the same session, with the values that
// are now in force, accepts it.
struct Resume {
  SessionId session;
  Bytes32 proof{};  // resumption_proof (protocol/seal_exporter.h)
  friend bool operator==(const Resume&, const Resume&) = default;
};

// Sent by the server with kFeatureWaiting, about once a second while a Hello or Resume has no answer yet.
struct Waiting {
  static constexpr uint8_t kUnknown = 255;

  std::string text;            // for a person: what is waited for
  uint8_t percent = kUnknown;  // of it that is done, up to 100; or kUnknown
  friend bool operator==(const Waiting&, const Waiting&) = default;
};

// Sent by the server with kFeatureWebTransport, after Welcome and whenever another one holds: the way to the session's
// datagrams by WebTransport.
struct WebTransport {
  uint16_t port = 0;            // UDP, at the server's address
  std::string ticket;           // opens it once; letters and digits
  std::vector<Bytes32> hashes;  // SHA-256 of the certificates that it may show; if empty, one that browsers trust
  friend bool operator==(const WebTransport&, const WebTransport&) = default;
};

using Message = std::variant<Hello, Welcome, Refused, SceneChanged, LightsChanged, Degraded, Draining, Stats, Bye,
                             Data, Resume, Waiting, WebTransport>;

// Encodes a complete message: length, type, body. Texts and lists longer than WIRE.md allows are truncated; bytes of a
// text that are control characters or not UTF-8 become '?'. Precondition: all other values are valid.
std::vector<uint8_t> encode(const Message& message);

// Splits a byte stream into messages: call feed() with received bytes, then next() until it gives none. One thread.
class MessageReader {
 public:
  // `max_bytes` is the longest message accepted, its length field included (a server accepts short ones only).
  explicit MessageReader(size_t max_bytes = kMaxControlBytes) : max_bytes_(max_bytes) {}

  void feed(std::span<const uint8_t> bytes);

  // nullopt if no further message is complete. Messages of unknown type are skipped. An error is final: the connection
  // is to be closed.
  Result<std::optional<Message>> next();

 private:
  Error fail(std::string why);

  size_t max_bytes_;
  std::vector<uint8_t> buffer_;
  size_t read_ = 0;  // bytes of buffer_ that are already decoded
  std::optional<Error> failed_;
};

}  // namespace gnomon::protocol
