// One frame's way through the daemon: each stage takes one of these values and hands the next one on.
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
  TimePoint deadline = TimePoint::max();  // of use until then; max: not said
  // What its link takes at the moment.
  size_t slice_body_bytes = protocol::kMaxSliceBodyBytes;  // header and payload
  uint32_t coalesced = 0;                                  // views that it replaced while the link was busy
  TenantId tenant{};
};

// What later stages need to know of a frame, and when each was done with it.
struct FrameMeta {
  SessionId session;
  TenantId tenant;
  SceneId scene;
  uint32_t net_thread = 0;  // which one owns the session
  uint32_t device = 0;      // which one renders it
  FrameId frame;
  protocol::CodecId codec = protocol::CodecId::tiles_lz4;
  size_t slice_body_bytes = protocol::kMaxSliceBodyBytes;
  SessionReferencesPtr references;  // null: the client keeps none
  protocol::CameraView camera;
  TileGrid grid;
  bool tells_size = false;                 // the client wants to know that it is not the granted one
  uint32_t traced_lights = 0;              // of the grid's; the others are lit everywhere
  std::optional<protocol::Moment> moment;  // that the client is to be told
  uint32_t coalesced = 0;                  // views of this session replaced since its last frame
  TimePoint arrival;
  TimePoint deadline = TimePoint::max();
  TimePoint submitted;
  TimePoint rendered;
  TimePoint encode_began;
  TimePoint encoded;
  Nanoseconds gpu{};       // measured by the device
  Nanoseconds readback{};  // of it, the copy to host memory

  uint64_t traced_bits() const { return uint64_t{grid.width} * grid.height * traced_lights; }
};

struct RenderedFrame {
  FrameMeta meta;
  gpu::FrameLease mask;
};

// A session is served less, or again more, than before.
struct SessionDegraded {
  SessionId session;
  uint32_t net_thread = 0;
  protocol::Degraded news;
  uint32_t life = 0;  // of the session's, see SessionOpened
};

struct EncodedFrame {
  FrameMeta meta;
  protocol::EncodedFrame slices;
};

}  // namespace gnomon::daemon
