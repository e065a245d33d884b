// Values that both ends of the wire exchange. WIRE.md has their encoding.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "common/ids.h"
#include "common/result.h"

namespace gnomon::protocol {

inline constexpr uint16_t kVersion = 2;
inline constexpr size_t kMaxDatagramBytes = 1200;
// With kFeatureFeedback the server probes for paths that carry longer datagrams, up to an Ethernet jumbo frame's.
inline constexpr size_t kMaxProbedBytes = 8952;
inline constexpr size_t kMaxControlBytes = 1 << 20;
inline constexpr uint32_t kMaxSide = 7680;  // pixels
inline constexpr uint32_t kMaxLights = 256;

// Feature bits of Hello and Welcome.
inline constexpr uint64_t kFeatureMoments = 1;    // slices state the moment of a changing scene that they show
inline constexpr uint64_t kFeatureFeedback = 2;   // the client reports arrivals and takes probes of the path
inline constexpr uint64_t kFeatureParity = 4;     // the client rebuilds lost slices from parity
inline constexpr uint64_t kFeatureResume = 16;    // a session outlives its connection, and is resumed on another
inline constexpr uint64_t kFeatureSizes = 32;     // slices state their frame's size where it is not the granted one
inline constexpr uint64_t kFeaturePaths = 64;     // the client proves that it receives datagrams at its address
inline constexpr uint64_t kFeatureWaiting = 128;  // the client is told what it waits for before its Welcome
inline constexpr uint64_t kFeatureWebTransport = 256;  // the client is told where it may go on by WebTransport
inline constexpr uint64_t kFeatureFleet = 512;  // the client goes on at the server itself, past its fleet's door
inline constexpr uint64_t kFeatureSoft = 1024;  // area lights are seen from several points: soft shadows
inline constexpr uint64_t kFeatureReferences = 2048;  // the client decodes tiles_context and keeps frames for it

using Vec3 = std::array<float, 3>;
using Quat = std::array<float, 4>;  // x, y, z, w
using Bytes16 = std::array<uint8_t, 16>;
using Bytes32 = std::array<uint8_t, 32>;

// Ciphers of the data channel's seal.
enum class CipherId : uint8_t { aes_128_gcm = 1, chacha20_poly1305 = 2 };

// A larger number means a denser codec, by which daemon/session/handshake.cpp chooses.
enum class CodecId : uint8_t { raw32_lz4 = 0, tiles_lz4 = 1, tiles_context = 3 };  // 2: an earlier tiles_context
inline constexpr size_t kCodecNumbers = 4;                                         // every codec's number is less
inline constexpr std::array<CodecId, 3> kCodecs{CodecId::raw32_lz4, CodecId::tiles_lz4, CodecId::tiles_context};
bool is_known(CodecId codec);          // one of kCodecs
const char* to_string(CodecId codec);  // its name in WIRE.md
Result<CodecId> parse_codec(std::string_view name);

// A camera's pose and frustum: glTF axes (it looks along its own -Z, Y up), metres. The frustum is given by the
// tangents of its four half-angles, all positive for an ordinary one, so that the skewed frusta of headsets fit too.
// It covers exactly the traced buffer, prediction border included.
struct CameraView {
  Vec3 position{};
  Quat orientation{0, 0, 0, 1};  // unit; camera to world
  float tan_left = 1, tan_right = 1, tan_up = 1, tan_down = 1;
  float near_plane = 0.05f;  // metres; there is no far plane
  friend bool operator==(const CameraView&, const CameraView&) = default;
};

enum class LightKind : uint8_t { point = 0, spot = 1, directional = 2 };

struct LightInfo {
  LightKind kind = LightKind::point;
  Vec3 position{};
  Vec3 direction{};
  Vec3 color{};
  float intensity = 0;
  float range = 0;  // metres; 0: unlimited
  float inner_cone_cos = 1;
  float outer_cone_cos = 0;
  friend bool operator==(const LightInfo&, const LightInfo&) = default;
};

// The extent of a light, from which its shadows are soft; one for each light.
struct AreaInfo {
  uint8_t shape = 0;  // 0 point (no extent), 1 sphere, 2 disc, 3 rectangle
  Vec3 u{};           // from the middle to the edge, in the world
  Vec3 v{};
  bool is_area() const { return shape != 0; }
  friend bool operator==(const AreaInfo&, const AreaInfo&) = default;
};

// What both ends require of these on arrival: every number is finite; orientations, and directions of spot and
// directional lights, are of unit length to within 0.001; width, height and near plane of a frustum are positive;
// intensity and range are not negative, and cosines are from -1 to 1.
bool is_valid(const CameraView& camera);
bool is_valid(const LightInfo& light);
bool is_valid(const AreaInfo& area);  // of a known shape, and finite

// The state that a frame shows of a scene in which something moves or whose lights were changed.
struct Moment {
  uint32_t scene_time_us = 0;   // within the scene's period
  uint32_t lights_version = 0;  // 0: the scene's own lights
  friend bool operator==(const Moment&, const Moment&) = default;
};

// A motion that the operator assigns to nodes of the scene's file.
struct NodeMotion {
  std::string node;
  uint8_t kind = 0;  // 0 spin, 1 shift
  Vec3 vector{};
  uint32_t period_us = 0;
  friend bool operator==(const NodeMotion&, const NodeMotion&) = default;
};

// What a client needs to know of a scene to match its own copy and to shade.
struct SceneManifest {
  std::string name;
  Bytes16 content_hash{};
  uint64_t triangles = 0;
  Vec3 bounds_min{};
  Vec3 bounds_max{};
  CameraView default_camera;
  std::vector<LightInfo> lights;
  friend bool operator==(const SceneManifest&, const SceneManifest&) = default;
};

}  // namespace gnomon::protocol
