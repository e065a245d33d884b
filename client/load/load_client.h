// One client of a load run: flies the camera path, checks the answers and keeps its figures. Draws nothing.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "client/cli/camera_pacer.h"
#include "client/cli/latency.h"
#include "client/load/load_figures.h"
#include "client/media/camera_path.h"
#include "client/net/reconnect.h"
#include "client/stream/moving_stream.h"

namespace gnomon::client {

class LoadClient {
 public:
  struct Options {
    StreamOptions stream;
    PaceOptions pace;
    Nanoseconds deadline{};  // see VisibilityStream::ask
    bool still = false;      // asks once; from then on the stream repeats that camera
    bool reopen = false;     // while flying, a session that is lost is opened again
    double phase = 0;        // where on the path it starts, as a share of its duration
  };

  LoadClient(Loop& loop, const Options& options);

  // True once it is connected, refused or failed.
  bool settled() const { return stream_->connection().state() != Connection::State::connecting; }
  bool open() const { return stream_->connection().state() == Connection::State::open; }
  const MovingStream& stream() const { return *stream_; }  // of the newest session
  // What it waits for before it is connected, as the server said last; empty if it did not.
  const std::string& waits_for() const { return waits_for_; }

  // Sends cameras from `now` until stop(), if it is open. `path` is borrowed until then.
  void fly(const CameraPath& path, TimePoint now);
  void stop();
  void close() { stream_->close("load run over"); }

  // Forgets the figures so far: what was asked before it and is answered after it counts.
  void end_warm_up();

  // Since the warm-up, else since fly(). Times and frames in time are those up to stop().
  LoadFigures figures() const;
  // Of the same frames: from the camera's arrival at the server to the frame's sending, as the server reports it.
  const Latencies& server_times() const { return server_times_; }

 private:
  void on_answer(const Answer& answer);
  void on_message(const protocol::Message& message);
  uint64_t pending() const;
  void note_gap(TimePoint now);
  std::unique_ptr<MovingStream> connect();
  void on_opened();
  void on_closed();
  void reopen();
  StreamCounters counters() const;  // of all sessions
  uint64_t received_bytes() const;
  void send_when_due();

  Options options_;
  const CameraPath* path_ = nullptr;  // while flying
  TimePoint started_{};
  std::optional<CameraPacer> pacer_;
  std::string waits_for_;
  LoadFigures figures_;    // but for what the stream counts
  StreamCounters before_;  // what the stream had counted when the warm-up ended
  uint64_t bytes_before_ = 0;
  StageTimes times_of_stats_;  // when the last Stats came
  Latencies server_times_;
  std::optional<TimePoint> last_whole_;  // when a whole frame came last
  Loop& loop_;
  Timer send_timer_;
  Timer reopen_timer_;
  Reconnect reconnect_;
  bool lost_ = false;
  uint32_t asked_ = 0;
  StreamCounters lost_counters_;  // of sessions that were lost
  uint64_t lost_bytes_ = 0;
  std::unique_ptr<MovingStream> stream_;
};

}  // namespace gnomon::client
