// What an engine uses: ask for a camera, get its visibility. See client/view/example.cpp.
//
//   ask(camera) -> CameraUpdate (+ acknowledgements) ... FrameSlices -> FrameAssembler -> Answer
//
// Any number of cameras may be in flight; the server renders the newest that it has received, so that some are never
// answered. The newest camera is repeated a few times a second, so that a lost datagram costs little and the server
// does not take a client that pauses for one that has vanished.
// Belongs to one Loop and its thread.
#pragma once

#include <functional>
#include <optional>

#include "client/net/ack_list.h"
#include "client/net/arrival_report.h"
#include "client/net/connection.h"
#include "client/stream/frame_assembler.h"
#include "client/stream/light_versions.h"
#include "client/stream/mask_shape.h"
#include "client/stream/requested_frames.h"
#include "client/stream/slice_recovery.h"

namespace gnomon::client {

// The visibility of one camera: complete, or without the tiles that mask.missing_tiles() names.
struct Answer {
  protocol::CameraView camera;
  const AssembledFrame& mask;  // borrowed for the call
  // The lights that were traced, or the newest known ones if the message that describes them has not come yet. Lights
  // that animations move stand where they are at scene time 0.
  const std::vector<protocol::LightInfo>& lights;
  Nanoseconds response;  // from the camera's sending to the last slice's arrival
  uint32_t index = 0;    // the caller's number of the camera
};

struct StreamOptions {
  ConnectOptions connect;
  SampleCounts samples = {};  // wanted at most; the server says what it grants
  // Complete frames are kept for slices of tiles_context to refer to: fewer bytes, some megabytes of memory.
  bool keep_references = true;
  // How long an incomplete frame waits for another slice before it is handed over with tiles missing.
  Nanoseconds patience = std::chrono::milliseconds(250);
  // How long a camera may go unanswered before it is forgotten.
  Nanoseconds answer_timeout = std::chrono::seconds(10);
};

struct StreamCounters {
  uint64_t asked = 0;
  uint64_t complete = 0;     // frames
  uint64_t incomplete = 0;   // frames handed over with tiles missing
  uint64_t superseded = 0;   // cameras without answer while a newer one has got one
  uint64_t unanswered = 0;   // cameras without answer for the timeout, and no newer one either
  uint64_t lost_slices = 0;  // of incomplete frames
  uint64_t duplicate_slices = 0;
  uint64_t late_slices = 0;        // of frames already handed over, or of other answers to their cameras
  uint64_t unreadable_slices = 0;  // that refer to frames which are not kept any more
  uint64_t rebuilt_slices = 0;     // from parity
  uint64_t resumed = 0;            // control connections that were lost and replaced
  uint64_t moved = 0;              // sessions that another one took the place of (MovingStream)
  uint64_t invalid_slices = 0;     // slices of frames never requested, that contradict their frame or do not decode

  StreamCounters& operator+=(const StreamCounters& other);
  StreamCounters& operator-=(const StreamCounters& other);  // what was counted since `other`
};

class VisibilityStream {
 public:
  struct Events {
    std::function<void(const Answer&)> answer = {};
    std::function<void()> opened = {};                           // this and those below may be empty
    std::function<void(const protocol::Message&)> message = {};  // Stats, Degraded, ...; before opened(), Waiting
    std::function<void(const Error&)> closed = {};
  };

  VisibilityStream(Loop& loop, StreamOptions options, Events events);

  Result<void> wait_open() { return connection_.wait_open(); }
  void close(const std::string& reason) { connection_.close(reason); }
  const Connection& connection() const { return connection_; }

  // The grid and the scene of the masks; empty before the session is open. The server may change both in mid-session (Degraded, SceneChanged).
  TileGrid grid() const { return assembler_ ? assembler_->grid() : TileGrid{}; }
  // The scene's lights are the newest ones.
  const protocol::SceneManifest& scene() const { return scene_; }

  // Sends a camera, whose frustum covers the whole traced buffer, once open. Ids count from 1. `index`: the caller's own
  // number of the camera.
  FrameId ask(const protocol::CameraView& camera, Nanoseconds display_deadline = {}, uint32_t index = 0);

  // Cameras asked since the newest one that has been answered.
  size_t in_flight() const { return requested_.in_flight(); }
  const StreamCounters& counters() const { return counters_; }

 private:
  void start();
  void continue_resumed();
  void adopt(const protocol::Welcome& welcome);
  void restart_with(MaskShape shape);
  void on_message(const protocol::Message& message);
  void on_datagram(const protocol::Opened& datagram, TimePoint arrived);
  void on_slice(std::span<const uint8_t> body);
  void add_rebuilt(const std::vector<std::vector<uint8_t>>& bodies);
  bool has(uint64_t feature) const;  // granted
  void plan_report();
  void report_arrivals();
  void add_slice(const protocol::FrameSlice& slice);
  void deliver_finished();
  void send_newest();
  void upkeep(TimePoint now);
  void expire(TimePoint now);

  StreamOptions options_;
  Events events_;
  std::optional<FrameAssembler> assembler_;
  protocol::SceneManifest scene_;
  MaskShape shape_;
  LightVersions lights_;
  AckList acks_;  // where there is no feedback
  ArrivalReport arrivals_;
  SliceRecovery recovery_;
  bool report_planned_ = false;
  RequestedFrames requested_;
  FrameId first_of_grid_{1};  // slices of earlier frames are dropped: their grid may differ
  StreamCounters counters_;
  protocol::CameraUpdate newest_;  // as last sent
  uint32_t newest_index_ = 0;
  TimePoint last_sent_{};
  std::vector<uint8_t> body_;
  Nanoseconds repeat_interval_{};
  Timer upkeep_timer_;
  Timer report_timer_;
  Connection connection_;
};

}  // namespace gnomon::client
