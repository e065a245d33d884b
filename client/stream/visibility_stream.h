// What an engine uses: ask for a camera, get its visibility. See client/view/example.cpp.
//
//   ask(camera) -> CameraUpdate (+ acknowledgements) ... FrameSlices -> FrameAssembler -> Answer
//
// Any number of cameras may be in flight; the server renders the newest that it has, so some are never answered. The
// newest camera is repeated a few times a second: a lost datagram costs little, and a client that pauses is not taken
// for one that has vanished.
// Belongs to one Loop and its thread.
#pragma once

#include <deque>
#include <functional>
#include <map>
#include <optional>

#include "client/net/ack_list.h"
#include "client/net/arrival_report.h"
#include "client/net/connection.h"
#include "client/stream/frame_assembler.h"
#include "client/stream/slice_recovery.h"

namespace gnomon::client {

// The visibility of one camera: whole, or without the tiles that mask.missing_tiles() names.
struct Answer {
  protocol::CameraView camera;
  const AssembledFrame& mask;  // borrowed for the call
  // The lights that were traced, as far as the server has told; those that animations move as at scene time 0.
  const std::vector<protocol::LightInfo>& lights;
  Nanoseconds response;  // from the camera's sending to the last slice's arrival
};

struct StreamOptions {
  ConnectOptions connect;
  // Whole frames are kept for slices of tiles_context to refer to: fewer bytes, some megabytes of memory.
  bool keep_references = true;
  // How long an unfinished frame waits for another slice before it is handed over as it is.
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
  uint64_t wrong_frames = 0;       // slices of frames never asked for, that contradict their frame or do not decode

  StreamCounters& operator+=(const StreamCounters& other);
};

class VisibilityStream {
 public:
  struct Events {
    std::function<void(const Answer&)> answer = {};
    std::function<void()> opened = {};  // may be empty, as those below
    // The session was resumed; the newest camera, not answered yet, is asked for anew under the next id.
    std::function<void()> asked_again = {};
    std::function<void(const protocol::Message&)> message = {};  // Stats, Degraded, Draining, ...
    std::function<void(const Error&)> closed = {};
  };

  VisibilityStream(Loop& loop, StreamOptions options, Events events);

  Result<void> wait_open() { return connection_.wait_open(); }
  void close(const std::string& reason) { connection_.close(reason); }
  const Connection& connection() const { return connection_; }

  // What the masks are of; once open. The server may change both in mid-session (Degraded, SceneChanged).
  const TileGrid& grid() const { return assembler_->grid(); }
  // The scene's lights are the newest ones.
  const protocol::SceneManifest& scene() const { return scene_; }

  // Sends a camera; its frustum covers the whole traced buffer. Ids count from 1. Once open.
  FrameId ask(const protocol::CameraView& camera, Nanoseconds display_deadline = {});

  // Cameras asked since the newest one that has been answered.
  size_t in_flight() const { return newest_asked_.value - newest_answered_.value; }
  const StreamCounters& counters() const { return counters_; }

 private:
  struct Asked {
    protocol::CameraView camera;
    TimePoint sent;
    std::optional<TimePoint> last_slice;
    bool answered = false;
  };

  void start();
  void go_on();
  void take_up(const protocol::Welcome& welcome);
  void restart_with(TileGrid grid);
  void on_message(const protocol::Message& message);
  void on_datagram(const protocol::Opened& datagram, TimePoint arrived);
  void on_slice(std::span<const uint8_t> body);
  void add_rebuilt(const std::vector<std::vector<uint8_t>>& bodies);
  bool has(uint64_t feature) const;  // granted
  bool may_be_asked_for(FrameId frame) const;
  bool is_of_grid(const protocol::SliceHeader& header) const;
  void plan_report();
  void report_arrivals();
  void add_slice(const protocol::FrameSlice& slice);
  void deliver_finished();
  void send_newest();
  void upkeep(TimePoint now);
  void expire(TimePoint now);
  Asked* find(FrameId frame);
  void keep_lights(uint32_t version, const std::vector<protocol::LightInfo>& lights);
  const std::vector<protocol::LightInfo>& lights_of(uint32_t version) const;

  StreamOptions options_;
  Events events_;
  std::optional<FrameAssembler> assembler_;
  protocol::SceneManifest scene_;
  std::map<uint32_t, std::vector<protocol::LightInfo>> lights_;  // by version, the newest few
  AckList acks_;                                                 // where there is no feedback
  ArrivalReport arrivals_;
  SliceRecovery recovery_;
  bool report_planned_ = false;
  std::deque<Asked> asked_;  // of consecutive frames up to newest_asked_
  FrameId newest_asked_{0};
  FrameId newest_answered_{0};
  FrameId first_of_use_{1};  // what comes of frames before it is dropped
  StreamCounters counters_;
  protocol::CameraUpdate newest_;  // as last sent
  TimePoint last_sent_{};
  std::vector<uint8_t> body_;
  Nanoseconds repeat_interval_{};
  Timer upkeep_timer_;
  Timer report_timer_;
  Connection connection_;
};

}  // namespace gnomon::client
