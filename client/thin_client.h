// The complete client in one object, for engines: takes a camera every frame and returns what to show.
// client/view/example.cpp demonstrates its use.
//
//   look(camera) -> VisibilityStream ... masks -> ShowOrder -> next(): draw this camera with these masks
//
// If the connection to the server is lost it reconnects by itself, and meanwhile shows what it has. If the server drains in
// a fleet, it moves to another one without a gap. Belongs to one Loop and its thread.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "client/net/reconnect.h"
#include "client/prediction/border.h"
#include "client/prediction/show_order.h"
#include "client/stream/moving_stream.h"

namespace gnomon::client {

struct ThinClientOptions {
  StreamOptions stream;  // its Hello asks for the traced size
  Mode mode = Mode::predicted;
  size_t ahead = 4;                             // x (client/prediction/mode.h) of mode `predicted`
  std::unique_ptr<PredictionPolicy> automatic;  // what chooses x in mode `auto`
  bool reconnect = true;                        // after a connection that was open is lost
};

// Masks as they arrived, and the camera that they are of.
struct ReceivedMasks {
  uint32_t index = 0;  // of the camera: how many look() was called with before it
  protocol::CameraView camera;
  AssembledFrame mask;  // mask.missing_tiles(): what did not arrive
  std::vector<protocol::LightInfo> lights;
  Nanoseconds response{};  // from the camera's sending to the last slice's arrival
};

// What to draw. If `reprojected` is false, the masks are this camera's own or, in mode non-sequential, are to be used
// as if they were.
struct Showing {
  uint32_t index = 0;
  uint32_t newest = 0;  // index of the newest camera
  protocol::CameraView camera;
  std::shared_ptr<const ReceivedMasks> seen;
  bool reprojected = false;
  Nanoseconds age{};  // since look() was called with the camera: the response time

  size_t ahead() const { return index - seen->index; }
};

class ThinClient {
 public:
  // Called while the loop runs; each may be empty. They must not destroy the client.
  struct Events {
    std::function<void(const ReceivedMasks&)> received = {};
    std::function<void(const protocol::Message&)> message = {};
    std::function<void(const Error&)> lost = {};  // a session that is replaced now, with the reason for its end
  };

  // Starts to connect. `loop` outlives the client.
  ThinClient(Loop& loop, ThinClientOptions options, Events events);
  ThinClient(Loop& loop, ThinClientOptions options) : ThinClient(loop, std::move(options), Events{}) {}
  ~ThinClient();

  // Serves the loop until the session is open. Error: why it is not (one line).
  Result<void> wait_open();
  // Why the client is without a session for good; nullopt as long as it has one or tries to get one.
  const std::optional<Error>& failure() const { return failure_; }
  // The server's answer to the newest connection, if it was Refused, or if it keeps this client out.
  const std::optional<protocol::Refused>& refusal() const { return stream_->connection().refusal(); }
  bool online() const { return stream_ && stream_->connection().state() == Connection::State::open; }
  uint32_t reconnects() const { return reconnects_; }

  // Takes the camera of this frame. Without a session it is not sent, but may still be shown. `display_deadline` is how
  // long after now its answer is useful; 0: not said.
  void look(const protocol::CameraView& camera, Nanoseconds display_deadline = {});

  // What to show now; nullopt if that has not changed since the last call, or no masks have arrived yet.
  std::optional<Showing> next();

  // Reports how wrong a prediction was (PredictionPolicy::observe), from which mode `auto` learns.
  void observe(const protocol::CameraView& earlier, const protocol::CameraView& later, double error) {
    order_.ahead().observe(earlier, later, error);
  }

  // Those below are of the newest session unless they say otherwise. Precondition: wait_open() has returned without
  // error. While a lost connection is being replaced, welcome() and scene() may be empty.
  size_t in_flight() const { return stream_->in_flight(); }
  const protocol::Welcome& welcome() const { return stream_->connection().welcome(); }
  const protocol::SceneManifest& scene() const { return stream_->scene(); }
  TileGrid grid() const { return stream_->grid(); }  // empty while not online()
  StreamCounters counters() const;                   // of all sessions; they say how often it moved
  uint64_t received_bytes() const;                   // of all sessions
  void close(const std::string& reason);

 private:
  void connect();
  void on_answer(const Answer& answer);
  void on_closed(const Error& error);

  Loop& loop_;
  ThinClientOptions options_;
  Events events_;
  ShowOrder order_;
  Reconnect reconnect_;
  std::optional<Error> failure_;
  std::optional<Error> ended_;  // why the session that was open last is no longer, until another one is
  bool opened_once_ = false;
  bool closed_ = false;
  uint32_t reconnects_ = 0;
  StreamCounters counters_before_;  // of connections that were lost
  uint64_t bytes_before_ = 0;
  std::shared_ptr<const ReceivedMasks> seen_;
  std::unique_ptr<MovingStream> stream_;
  Timer retry_;
};

}  // namespace gnomon::client
