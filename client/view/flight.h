// Flies a camera path with a server's visibility: takes the path's cameras as the mode requires, and has what is to be
// shown drawn.
#pragma once

#include <functional>

#include "client/cli/camera_pacer.h"
#include "client/cli/latency.h"
#include "client/media/camera_path.h"
#include "client/thin_client.h"
#include "common/progress.h"

namespace gnomon::client {

struct FlightOptions {
  StreamOptions stream;  // its Hello asks for the traced size
  Mode mode = Mode::sequential;
  size_t ahead = 4;               // x of mode predicted
  double cost_per_s = 0.15;       // of mode auto: ErrorBalanceOptions::cost_per_s
  bool border_by_motion = false;  // more of the border lies where the camera turns to
  double rate_hz = 0;             // cameras a second at most; 0: as the mode allows
  ViewSize size;
  uint32_t frames = 60;  // steps in which the path is flown once
  std::function<void(const protocol::Message&)> message =
      {};  // the server's news; what it waits for before open() ends
  std::function<bool()> interrupted = [] { return false; };  // asked often; once true, the flight ends early
};

struct FlightStats {
  StreamCounters counters;
  uint64_t pending = 0;  // cameras that were still without an answer when it ended
  Latencies latencies;   // response times of complete frames, drawing not included
  Latencies ages;        // of what was shown, as its drawing began: the dissertation's response time
  double seconds = 0;
  uint64_t bytes = 0;  // of received datagrams
  double draw_seconds = 0;
  uint64_t shown = 0;         // pictures
  uint64_t frames_ahead = 0;  // sum of x over the pictures shown
  uint32_t reconnects = 0;

  uint64_t frames() const { return counters.complete + counters.incomplete; }
  double per_second(uint64_t count) const { return seconds > 0 ? static_cast<double>(count) / seconds : 0; }
  double vbps() const { return per_second(counters.complete); }
  double fps() const { return per_second(shown); }
  double mean_ahead() const { return shown ? static_cast<double>(frames_ahead) / static_cast<double>(shown) : 0; }
  double bytes_per_frame() const {
    return frames() ? static_cast<double>(bytes) / static_cast<double>(frames()) : 0;
  }
};

// One thread; it owns its loop. In mode `sequential` a frame is drawn before the next is asked for; in the others
// drawing overlaps with the server's work, and masks that arrive meanwhile are read when the drawing is done.
class Flight {
 public:
  using Draw = std::function<Result<void>(const Showing&)>;

  explicit Flight(FlightOptions options);

  // Connects. Error: one line, also if the server offers another size than asked for, or the scene has no lights.
  Result<void> open();
  // Whether the server's operator keeps this client out: why open() or fly() has failed.
  bool kept_out() const;
  const protocol::Welcome& welcome() const { return client_.welcome(); }

  // Runs until every step has been asked for and answered, or given up, or the flight is interrupted. The session is closed
  // before what was answered last is drawn. Error: of the connection or of `draw`.
  Result<void> fly(const CameraPath& path, const Draw& draw, Progress& progress);
  void close() { client_.close("flight over"); }

  // See ThinClient::observe(). Called from `draw`.
  void observe(const protocol::CameraView& earlier, const protocol::CameraView& later, double error) {
    client_.observe(earlier, later, error);
  }

  FlightStats figures() const;

 private:
  void on_received(const ReceivedMasks& received);
  bool may_ask(TimePoint now) const;
  void ask_next(const CameraPath& path, TimePoint now);
  BorderPlace border_place(const CameraPath& path, double seconds, double step) const;
  bool draws_on_masks() const;
  Result<void> draw_next(const Draw& draw);
  TimePoint next_event(TimePoint now) const;
  bool all_asked() const { return asked_ == options_.frames; }
  bool finished(TimePoint now) const;
  std::string progress_line(TimePoint now) const;

  FlightOptions options_;
  CameraPacer pacer_;
  uint32_t asked_ = 0;
  bool new_masks_ = false;  // since the last drawing
  TimePoint started_{};
  TimePoint last_asked_{};
  TimePoint ended_{};
  Nanoseconds drawing_{};
  FlightStats figures_;
  Loop loop_;
  ThinClient client_;
};

}  // namespace gnomon::client
