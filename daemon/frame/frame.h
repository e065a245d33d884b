// The values that carry a frame through the daemon: each stage takes one of them and passes the next one on.
//
//   ViewRequest -render loop, GPU-> RenderedFrame -encode pool-> EncodedFrame -net thread-> datagrams
#pragma once

#include <optional>

#include "common/clock.h"
#include "common/ids.h"
#include "daemon/frame/session_references.h"
#include "gpu/renderer.h"
#include "protocol/codec.h"
#include "protocol/messages.h"

namespace gnomon::daemon {

// A client asks for the visibility of one camera.
struct ViewRequest {
  SessionId session;
  FrameId frame;
  protocol::CameraView camera;
  TimePoint arrival;                      // of the datagram
  TimePoint deadline = TimePoint::max();  // when the client can no longer use the frame; max: no deadline
  // Longest slice body, header and payload, that the session's link carries at the moment.
  size_t slice_body_bytes = protocol::kMaxSliceBodyBytes;
  uint32_t coalesced = 0;  // views that this one replaced while the link was busy
  TenantId tenant{};
};

// Whose frame it is, and which threads and device handle it.
struct FrameRoute {
  SessionId session{};
  TenantId tenant{};
  SceneId scene{};
  uint32_t net_thread = 0;  // index of the net thread that owns the session
  uint32_t device = 0;      // number of the device that renders the frame
  FrameId frame{};
};

// What is rendered and how it is encoded.
struct FrameSpec {
  protocol::CodecId codec = protocol::CodecId::tiles_lz4;
  size_t slice_body_bytes = protocol::kMaxSliceBodyBytes;
  SessionReferencesPtr references = nullptr;  // shared with the session; nullptr if the client keeps no frames
  protocol::CameraView camera = {};
  TileGrid grid = {};
  bool tells_size = false;  // slices carry the size, as it is not the granted one
  SampleCounts samples = {};
  bool tells_samples = false;                   // slices carry them, as they are not the granted ones
  uint64_t traced_bits = 0;                     // scheduler::weighted_bits() of the lights that are traced
  std::optional<protocol::Moment> moment = {};  // of the scene; carried by the slices
};

// When each stage was finished, and what the device measured.
struct FrameTimes {
  TimePoint arrival{};  // of the datagram that asked for it
  TimePoint deadline = TimePoint::max();
  TimePoint submitted{};
  TimePoint rendered{};
  TimePoint encode_began{};
  TimePoint encoded{};
  Nanoseconds gpu{};       // measured by the device
  Nanoseconds readback{};  // the part of `gpu` that copies to host memory
};

// What later stages need to know of a frame.
struct FrameMeta {
  FrameRoute route = {};
  FrameSpec spec = {};
  FrameTimes times = {};
  uint32_t coalesced = 0;  // views of this session that were replaced since its last frame
};

struct RenderedFrame {
  FrameMeta meta;
  gpu::FrameLease mask;
};

// What a session is served has changed: its rate, samples, size or lights.
struct SessionDegraded {
  SessionId session;
  uint32_t net_thread = 0;
  protocol::Degraded message;
  uint32_t generation = 0;  // of the session, see SessionOpened
};

struct EncodedFrame {
  FrameMeta meta;
  protocol::EncodedMask slices;
};

}  // namespace gnomon::daemon
