#include "client/load/load_client.h"

#include <algorithm>

#include "client/cli/waiting_line.h"

namespace gnomon::client {

LoadClient::LoadClient(Loop& loop, const Options& options)
    : options_(options),
      loop_(loop),
      send_timer_(loop, [this] { send_when_due(); }),
      reopen_timer_(loop, [this] { reopen(); }),
      stream_(connect()) {}

std::unique_ptr<MovingStream> LoadClient::connect() {
  return std::make_unique<MovingStream>(
      loop_, options_.stream,
      MovingStream::Events{.answer = [this](const Answer& answer) { on_answer(answer); },
                           .opened = [this] { on_opened(); },
                           .message = [this](const protocol::Message& message) { on_message(message); },
                           .closed = [this](const Error&) { on_closed(); }});
}

void LoadClient::on_opened() {
  reconnect_.connected();
  if (!lost_) return;
  lost_ = false;
  ++figures_.reopened;
  send_when_due();
}

void LoadClient::on_closed() {
  if (!options_.reopen || !path_) return;
  const auto wait = reconnect_.wait_after(stream_->connection().refusal());
  if (!wait) return;
  lost_ = true;
  reopen_timer_.arm(Clock::now() + *wait);
}

void LoadClient::reopen() {
  lost_counters_ += stream_->counters_at_end();
  lost_bytes_ += stream_->received_bytes();
  stream_ = connect();
}

StreamCounters LoadClient::counters() const {
  StreamCounters sum = lost_counters_;
  sum += stream_->counters();
  return sum;
}

uint64_t LoadClient::received_bytes() const { return lost_bytes_ + stream_->received_bytes(); }

void LoadClient::on_message(const protocol::Message& message) {
  if (const auto* waiting = std::get_if<protocol::Waiting>(&message)) waits_for_ = describe(*waiting);
  const auto* stats = std::get_if<protocol::Stats>(&message);
  if (!stats || !path_) return;
  figures_.times.take_queue(times_of_stats_, std::chrono::microseconds(stats->queue_us));
  times_of_stats_ = figures_.times;
}

void LoadClient::fly(const CameraPath& path, TimePoint now) {
  path_ = &path;
  started_ = now;
  // Clients with the same rate are spread over its interval, as real ones would be.
  const double rate = options_.pace.rate_hz;
  const std::chrono::duration<double> offset(rate > 0 ? options_.phase / rate : 0);
  pacer_.emplace(options_.pace, now + std::chrono::duration_cast<Nanoseconds>(offset));
  send_when_due();
}

void LoadClient::stop() {
  if (path_ && open()) note_gap(Clock::now());
  path_ = nullptr;
  send_timer_.disarm();
  reopen_timer_.disarm();
}

void LoadClient::send_when_due() {
  if (!path_ || !open() || (options_.still && counters().asked > 0)) return;
  const TimePoint now = Clock::now();
  if (pacer_->next_send(stream_->in_flight()) <= now) {
    const double seconds = to_seconds(now - started_) + options_.phase * path_->duration_seconds();
    const TileGrid grid = stream_->grid();
    stream_->ask(view_of(path_->at(seconds), {.width = grid.width, .height = grid.height}), options_.deadline,
                 asked_++);
    pacer_->sent(now);
  }
  send_timer_.arm(pacer_->next_send(stream_->in_flight()));
}

// Cameras whose answer may still come. Of those in flight, some may have been given up; these are the oldest.
uint64_t LoadClient::pending() const {
  const StreamCounters c = stream_->counters();
  return std::min<uint64_t>(stream_->in_flight(),
                            c.asked - c.complete - c.incomplete - c.superseded - c.unanswered);
}

void LoadClient::end_warm_up() {
  figures_ = {};
  times_of_stats_ = {};
  server_times_ = {};
  last_whole_.reset();
  before_ = counters();
  before_.asked -= pending();
  bytes_before_ = received_bytes();
}

LoadFigures LoadClient::figures() const {
  LoadFigures figures = figures_;
  figures.counters = counters();
  figures.counters -= before_;
  figures.pending = pending();
  figures.bytes = received_bytes() - bytes_before_;
  return figures;
}

// Of one that asks once, there is none.
void LoadClient::note_gap(TimePoint now) {
  if (last_whole_ && !options_.still) figures_.longest_gap = std::max(figures_.longest_gap, now - *last_whole_);
  last_whole_ = now;
}

void LoadClient::on_answer(const Answer& answer) {
  if (!path_) return;
  pacer_->answered(answer.response);
  const std::chrono::microseconds server(answer.mask.server_us);
  StageTimes& times = figures_.times;
  ++times.answers;
  times.response += answer.response;
  const Nanoseconds at_server = std::min<Nanoseconds>(server, answer.response);
  times.server += at_server;
  times.device += std::min<Nanoseconds>(std::chrono::microseconds(answer.mask.gpu_us), at_server);
  if (answer.mask.complete()) {
    ++figures_.frames_in_time;
    figures_.latencies.add(answer.response);
    server_times_.add(server);
    note_gap(Clock::now());
  }
  send_when_due();
}

}  // namespace gnomon::client
