// A stream of masks that outlives its server: when that drains in a fleet, another session is opened at the door, and
// takes the first one's place with its first whole frame. See protocol/WIRE.md, Moving.
//
//   ask(camera) -> the session in force, and from its Welcome on the one that will follow ... -> answer
//
// What an engine sees is one stream: cameras have the engine's own numbers, and with a move answers do not go back. Belongs
// to one Loop and its thread.
#pragma once

#include <map>
#include <memory>
#include <optional>

#include "client/net/move_policy.h"
#include "client/stream/visibility_stream.h"

namespace gnomon::client {

class MovingStream {
 public:
  // Called while the loop runs; each may be empty. They may close the stream, but must not destroy it.
  struct Events {
    std::function<void(const Answer&)> answer = {};
    std::function<void()> opened = {};  // the first session
    // Another session is in force: connection(), grid() and scene() are its own.
    std::function<void()> moved = {};
    std::function<void(const protocol::Message&)> message = {};  // of the session in force; as VisibilityStream's
    std::function<void(const Error&)> closed = {};               // no session is left, nor on its way
  };

  // Starts to connect. `loop` outlives the stream.
  MovingStream(Loop& loop, StreamOptions options, Events events);

  Result<void> wait_open() { return stream_->wait_open(); }
  void close(const std::string& reason);

  // Those below are of the session in force unless they say otherwise.
  const Connection& connection() const { return stream_->connection(); }
  TileGrid grid() const { return stream_->grid(); }
  const protocol::SceneManifest& scene() const { return stream_->scene(); }
  size_t in_flight() const { return stream_->in_flight(); }

  // As VisibilityStream::ask; `index` is the caller's number of the camera, which its answer has too. It grows: what one
  // session has answered is not handed on again when another one answers it.
  void ask(const protocol::CameraView& camera, Nanoseconds display_deadline, uint32_t index);

  StreamCounters counters() const;  // of all sessions; a camera that two were asked for counts once
  // The same when no answer will come any more: every camera is in one of them.
  StreamCounters counters_at_end() const;
  uint64_t received_bytes() const;  // of all sessions
  bool is_moving() const { return next_ != nullptr; }

 private:
  std::unique_ptr<VisibilityStream> make();
  bool is_in_force(uint32_t number) const { return number == number_; }
  void on_opened(uint32_t number);
  void on_answer(uint32_t number, const Answer& answer);
  void on_message(uint32_t number, const protocol::Message& message);
  void on_closed(uint32_t number, const Error& error);
  void on_drain(const protocol::Draining& draining);
  void open_next();
  void give_up_next();
  void take_over();
  void announce_move();
  void retire(std::unique_ptr<VisibilityStream> stream);

  struct Newest {
    protocol::CameraView camera;
    Nanoseconds display_deadline;
    uint32_t index;
  };

  Loop& loop_;
  StreamOptions options_;
  Events events_;
  MovePolicy policy_;
  std::optional<Newest> newest_;
  std::optional<uint32_t> newest_answered_;  // index
  std::optional<uint32_t> answered_before_;  // the newest that sessions which are over have answered
  StreamCounters before_;                    // of sessions that are over
  uint64_t bytes_before_ = 0;
  // What the session to come was told, by kind; it is passed on when that session is in force.
  std::map<size_t, protocol::Message> told_next_;
  uint32_t made_ = 0;    // streams so far
  uint32_t number_ = 0;  // of the one in force
  std::unique_ptr<VisibilityStream> stream_;
  std::unique_ptr<VisibilityStream> next_;     // asked for at the door; nullptr while none is
  std::unique_ptr<VisibilityStream> retired_;  // is over, and may still be on the stack
  Timer begin_timer_;
  Timer retire_timer_;
};

}  // namespace gnomon::client
