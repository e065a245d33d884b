// Datagrams of the data channel: camera updates to the server, frame slices to the client. WIRE.md has the byte tables.
//
//   | header 20 bytes: version u8, kind u8, flags u16, session u64, sequence u64 | body | seal tag 16 bytes |
//
// Decoding is total (any bytes give a value or nullopt) and allocates nothing.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/ids.h"
#include "protocol/types.h"

namespace gnomon::protocol {

// Bits of SliceHeader::flags.
inline constexpr uint8_t kSliceHasMoment = 1;
inline constexpr uint8_t kSliceIsPadded = 2;    // only with kFeatureFeedback
inline constexpr uint8_t kSliceHasSize = 4;     // only with kFeatureSizes
inline constexpr uint8_t kSliceHasSamples = 8;  // only with kFeatureSoft
inline constexpr size_t kHeaderBytes = 20;
inline constexpr size_t kTagBytes = 16;
inline constexpr size_t kSliceHeaderBytes = 32;
inline constexpr size_t kMomentBytes = 8;
inline constexpr size_t kSizeBytes = 4;
inline constexpr size_t kSamplesBytes = 1;
inline constexpr size_t kMaxSliceBodyBytes = kMaxDatagramBytes - kHeaderBytes - kTagBytes;
inline constexpr size_t kMaxSlicePayloadBytes = kMaxSliceBodyBytes - kSliceHeaderBytes;

// Body of ping and pong, whose datagrams have kMaxDatagramBytes: as long as the longest that every session uses.
inline constexpr size_t kPingBytes = kMaxDatagramBytes - kHeaderBytes - kTagBytes;

// Body of path_challenge and path_response.
inline constexpr size_t kPathTokenBytes = 8;

enum class DatagramKind : uint8_t {
  camera_update = 1,
  frame_slice = 2,
  feedback = 3,      // protocol/feedback.h
  frame_parity = 4,  // protocol/parity.h
  probe = 5,         // zeros; tests whether the path carries a datagram of this size
  ping = 6,          // client to server, zeros; tests whether datagrams pass
  pong = 7,          // server to client, the answer, zeros
  // With kFeaturePaths:
  path_challenge = 8,  // server to client: a token
  path_response = 9,   // client to server: the same token, sent back
};
inline constexpr std::array<DatagramKind, 9> kDatagramKinds{
    DatagramKind::camera_update, DatagramKind::frame_slice,    DatagramKind::feedback,
    DatagramKind::frame_parity,  DatagramKind::probe,          DatagramKind::ping,
    DatagramKind::pong,          DatagramKind::path_challenge, DatagramKind::path_response};

struct Header {
  DatagramKind kind = DatagramKind::camera_update;
  uint16_t flags = 0;
  SessionId session;
  uint64_t sequence = 0;  // per session and direction, increasing, never repeated
  friend bool operator==(const Header&, const Header&) = default;
};

// Acknowledges slices of one frame: bit i of `slices` stands for slice first_slice + i.
struct SliceAck {
  FrameId frame;
  uint16_t first_slice = 0;
  uint64_t slices = 0;
  friend bool operator==(const SliceAck&, const SliceAck&) = default;
};

inline constexpr size_t kMaxAcks = 16;

struct CameraUpdate {
  FrameId frame;
  CameraView camera;
  uint64_t client_time_us = 0;       // client's clock, of any origin, when the camera was sampled
  uint32_t display_deadline_us = 0;  // after its arrival at the server; 0: none
  uint8_t ack_count = 0;
  std::array<SliceAck, kMaxAcks> acks{};
  FrameId have;  // with kFeatureReferences: the newest frame that the client keeps for slices to refer to; 0: none
  friend bool operator==(const CameraUpdate&, const CameraUpdate&) = default;
};

// A slice holds the tiles [first_tile, first_tile + tile_count) (row-major) of the lights
// [first_light, first_light + light_count) of one frame and decodes alone; in frames with several samples of an area
// light, of those planes (common/light_planes.h).
struct SliceHeader {
  FrameId frame;
  uint16_t slice = 0;
  uint16_t slice_count = 0;
  uint32_t first_tile = 0;
  uint32_t tile_count = 0;
  uint16_t first_light = 0;
  uint16_t light_count = 0;
  CodecId codec = CodecId::tiles_lz4;
  uint8_t flags = 0;
  uint16_t padding = 0;    // with kSliceIsPadded: bytes at the end of the body that are no payload
  uint32_t server_us = 0;  // from the camera's arrival to the frame's sending
  uint32_t gpu_us = 0;     // part of server_us: on the GPU
  Moment moment;           // on the wire with kSliceHasMoment, which takes kMomentBytes
  // The frame's size if it is not the granted one; on the wire with kSliceHasSize, which takes kSizeBytes.
  uint16_t width = 0, height = 0;
  // As to_byte(SampleCounts), if they are not the granted ones; on the wire with kSliceHasSamples, which takes kSamplesBytes.
  uint8_t samples = 0;
  friend bool operator==(const SliceHeader&, const SliceHeader&) = default;
};

struct FrameSlice {
  SliceHeader header;
  std::span<const uint8_t> payload;  // borrowed from the datagram
};

// nullopt if the bytes are malformed, or the header is of another version or an unknown kind.
std::optional<Header> decode_header(std::span<const uint8_t> datagram);
std::optional<CameraUpdate> decode_camera_update(std::span<const uint8_t> body);
std::optional<FrameSlice> decode_frame_slice(std::span<const uint8_t> body);
std::optional<uint64_t> decode_path_token(std::span<const uint8_t> body);

void write_header(std::span<uint8_t, kHeaderBytes> out, const Header& header);

// Append to `out`. Precondition: the camera is valid (is_valid); only decoding checks it.
void append_camera_update(std::vector<uint8_t>& out, const CameraUpdate& update);
void append_path_token(std::vector<uint8_t>& out, uint64_t token);
void append_frame_slice(std::vector<uint8_t>& out, const SliceHeader& header, std::span<const uint8_t> payload);

}  // namespace gnomon::protocol
