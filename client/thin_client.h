// The client in one object, for engines: looks through a camera every frame, says what to show. client/view/example.cpp is
// the whole use of it.
//
//   look(camera) -> VisibilityStream ... masks -> ShowOrder -> next(): draw this camera with these masks
//
// Loses its server and finds it again by itself: meanwhile it shows what it has. Belongs to one Loop and its thread.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "client/net/reconnect.h"
#include "client/prediction/border.h"
#include "client/prediction/show_order.h"
#include "client/stream/visibility_stream.h"

namespace gnomon::client {

struct ThinClientOptions {
  StreamOptions stream;  // its Hello asks for the traced size
  Mode mode = Mode::predicted;
  size_t ahead = 4;                  // x of mode `predicted`
  std::unique_ptr<Ahead> automatic;  // what chooses it in mode `auto`
  bool reconnect = true;
};

// Masks as they came, and the camera that they are of.
struct Received {
  uint32_t index = 0;  // of the camera, among all that were looked through
  protocol::CameraView camera;
  AssembledFrame mask;  // mask.missing_tiles(): what did not arrive
  std::vector<protocol::LightInfo> lights;
  Nanoseconds response{};  // from the camera's sending to the last slice's arrival
};

// What to draw. Not `reprojected`: the masks are this camera's own, or (non-sequential) are to be used as if they were.
struct Showing {
  uint32_t index = 0;
  uint32_t newest = 0;  // index of the camera of this moment
  protocol::CameraView camera;
  std::shared_ptr<const Received> seen;
  bool reprojected = false;
  Nanoseconds age{};  // since the camera was looked through: the response time

  size_t ahead() const { return index - seen->index; }
};

class ThinClient {
 public:
  struct Events {
    std::function<void(const Received&)> received = {};
    std::function<void(const protocol::Message&)> message = {};
  };

  ThinClient(Loop& loop, ThinClientOptions options, Events events);
  ThinClient(Loop& loop, ThinClientOptions options) : ThinClient(loop, std::move(options), Events{}) {}
  ~ThinClient();

  // Serves the loop until the session is open. Error: why it is not (one line).
  Result<void> wait_open();
  // Why there is no server, and none will be tried any more.
  const std::optional<Error>& failure() const { return failure_; }
  // The server's answer, if it was that.
  const std::optional<protocol::Refused>& refusal() const { return stream_->connection().refusal(); }
  bool online() const { return stream_ && stream_->connection().state() == Connection::State::open; }
  uint32_t reconnects() const { return reconnects_; }

  // The camera of this moment. Without a server it is not sent, but may be shown.
  void look(const protocol::CameraView& camera, Nanoseconds display_deadline = {});

  // What to show now; nothing new since the last call: nothing.
  std::optional<Showing> next();

  // What a prediction turned out to be, for mode `auto` to learn from.
  void observe(const protocol::CameraView& earlier, const protocol::CameraView& later, double error) {
    order_.ahead().observe(earlier, later, error);
  }

  // Once open, as those below; those of the last connection while another is being made.
  size_t in_flight() const { return stream_->in_flight(); }
  const protocol::Welcome& welcome() const { return stream_->connection().welcome(); }
  const protocol::SceneManifest& scene() const { return stream_->scene(); }
  const TileGrid& grid() const { return stream_->grid(); }  // not before it is open
  StreamCounters counters() const;                          // of all connections
  uint64_t received_bytes() const;                          // the same
  void close(const std::string& reason);

 private:
  void connect();
  void remember_asked(uint32_t index);
  void on_answer(const Answer& answer);
  void on_closed(const Error& error);

  Loop& loop_;
  ThinClientOptions options_;
  Events events_;
  ShowOrder order_;
  Reconnect reconnect_;
  std::optional<Error> failure_;
  bool opened_once_ = false;
  bool closed_ = false;
  uint32_t reconnects_ = 0;
  StreamCounters counters_before_;  // of connections that were lost
  uint64_t bytes_before_ = 0;
  std::deque<uint32_t> indices_;  // of the cameras asked for on this connection, from frame `first_frame_` on
  uint32_t first_frame_ = 1;
  std::shared_ptr<const Received> seen_;
  std::unique_ptr<VisibilityStream> stream_;
  Timer retry_;
};

}  // namespace gnomon::client
