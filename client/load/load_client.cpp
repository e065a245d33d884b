#include "client/load/load_client.h"

#include "client/cli/waiting_line.h"

namespace gnomon::client {

LoadClient::LoadClient(Loop& loop, const Options& options)
    : options_(options),
      send_timer_(loop, [this] { send_when_due(); }),
      stream_(loop, options.stream,
              {.answer = [this](const Answer& answer) { on_answer(answer); },
               .message = [this](const protocol::Message& message) { on_message(message); }}) {}

void LoadClient::on_message(const protocol::Message& message) {
  if (const auto* waiting = std::get_if<protocol::Waiting>(&message)) waits_for_ = describe(*waiting);
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
  path_ = nullptr;
  send_timer_.disarm();
}

void LoadClient::send_when_due() {
  if (!path_ || !open() || (options_.still && stream_.counters().asked > 0)) return;
  const TimePoint now = Clock::now();
  if (pacer_->next_send(stream_.in_flight()) <= now) {
    const double seconds = to_seconds(now - started_) + options_.phase * path_->duration_seconds();
    const TileGrid grid = stream_.grid();
    stream_.ask(view_of(path_->at(seconds), {.width = grid.width, .height = grid.height}), options_.deadline);
    pacer_->sent(now);
  }
  send_timer_.arm(pacer_->next_send(stream_.in_flight()));
}

void LoadClient::on_answer(const Answer& answer) {
  if (!path_) return;
  pacer_->answered(answer.response);
  if (answer.mask.complete()) {
    ++frames_in_time_;
    latencies_.add(answer.response);
    server_times_.add(std::chrono::microseconds(answer.mask.server_us));
  }
  send_when_due();
}

}  // namespace gnomon::client
