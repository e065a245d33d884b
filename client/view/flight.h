// Flies a camera path with a server's visibility: asks for cameras as the mode says, has every answer drawn.
#pragma once

#include <deque>
#include <functional>

#include "client/camera_path.h"
#include "client/latency.h"
#include "client/mode.h"
#include "client/pacer.h"
#include "client/progress.h"
#include "client/tile_cover.h"
#include "client/visibility_stream.h"

namespace gnomon::client {

struct FlightOptions {
  StreamOptions stream;  // its Hello asks for the traced size
  Mode mode = Mode::sequential;
  double rate_hz = 0;  // cameras a second at most; 0: as the mode allows
  ViewSize size;
  uint32_t frames = 60;  // the whole path in this many steps
};

struct FlownFrame {
  uint32_t index = 0;  // of the path's steps
  protocol::CameraView camera;
  AssembledFrame mask;
  std::vector<protocol::LightInfo> lights;
};

struct FlightFigures {
  StreamCounters counters;
  Latencies latencies;  // of complete frames; of reading them off the socket, drawing comes after
  double seconds = 0;
  uint64_t bytes = 0;  // received datagrams'
  double draw_seconds = 0;
  uint64_t covered_words = 0;  // tiles of one light that did not arrive and were shown as in the picture before

  uint64_t frames() const { return counters.complete + counters.incomplete; }
  double vbps() const { return seconds > 0 ? static_cast<double>(counters.complete) / seconds : 0; }
  double bytes_per_frame() const {
    return frames() ? static_cast<double>(bytes) / static_cast<double>(frames()) : 0;
  }
};

// One thread, its loop within. In mode `sequential` a frame is drawn before the next is asked for; in mode `queued`
// drawing overlaps with the server's work, and a frame that arrives meanwhile is read when the drawing is done.
class Flight {
 public:
  using Draw = std::function<Result<void>(const FlownFrame&)>;

  explicit Flight(const FlightOptions& options);

  // Connects. Error: one line, also when the server offers another size than asked for.
  Result<void> open();
  const protocol::Welcome& welcome() const { return stream_.connection().welcome(); }

  // Until every step has been asked for and answered, or given up. Error: of the connection or of `draw`.
  Result<void> fly(const CameraPath& path, const Draw& draw, Progress& progress);
  void close() { stream_.close("flight over"); }

  FlightFigures figures() const;

 private:
  void on_answer(const Answer& answer);
  void ask_next(const CameraPath& path, TimePoint now);
  Result<void> draw_next(const Draw& draw);
  TimePoint next_event(TimePoint now) const;
  bool all_asked() const { return stream_.counters().asked == options_.frames; }
  bool finished(TimePoint now) const;
  std::string progress_line(TimePoint now) const;

  FlightOptions options_;
  Pacer pacer_;
  TimePoint started_{};
  TimePoint last_asked_{};
  TimePoint ended_{};
  Nanoseconds drawing_{};
  Latencies latencies_;
  TileCover cover_;
  uint64_t covered_ = 0;  // words
  std::deque<FlownFrame> to_draw_;
  Loop loop_;
  VisibilityStream stream_;
};

}  // namespace gnomon::client
