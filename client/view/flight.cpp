#include "client/view/flight.h"

#include <algorithm>
#include <cstdio>

namespace gnomon::client {
namespace {

using namespace std::chrono_literals;

constexpr auto kTurn = 100ms;  // how often the loop looks at what has no event of its own

PaceOptions pace_of(const FlightOptions& options, float granted_hz) {
  double rate = options.rate_hz;
  if (granted_hz > 0 && (rate <= 0 || rate > static_cast<double>(granted_hz)))
    rate = static_cast<double>(granted_hz);
  return {.rate_hz = rate, .max_in_flight = max_in_flight(options.mode)};
}

Error size_changed(const TileGrid& grid) {
  return Error{"the server offers " + std::to_string(grid.width) + "x" + std::to_string(grid.height) +
               " (border included) at the moment: ask for that size"};
}

}  // namespace

Flight::Flight(const FlightOptions& options)
    : options_(options),
      pacer_({}, Clock::now()),
      stream_(loop_, options.stream, {.answer = [this](const Answer& answer) { on_answer(answer); }}) {}

Result<void> Flight::open() {
  if (auto opened = stream_.wait_open(); !opened) return opened;
  const TileGrid& grid = stream_.grid();
  if (grid.width != options_.size.traced_width() || grid.height != options_.size.traced_height()) {
    return size_changed(grid);
  }
  if (grid.lights == 0)
    return Error{"scene '" + stream_.scene().name + "' has no lights: there is nothing to ask for"};
  return {};
}

Result<void> Flight::fly(const CameraPath& path, const Draw& draw, Progress& progress) {
  started_ = Clock::now();
  pacer_ = Pacer(pace_of(options_, welcome().rate_hz), started_);
  for (TimePoint now = started_; !finished(now); now = Clock::now()) {
    if (const auto& failure = stream_.connection().failure()) return *failure;
    const bool may_ask = options_.mode != Mode::sequential || to_draw_.empty();
    if (may_ask && !all_asked() && pacer_.next_send(stream_.in_flight()) <= now) ask_next(path, now);
    if (progress.due(now)) progress.show(progress_line(now), now);
    if (to_draw_.empty()) {
      loop_.run_until(next_event(now), [this] { return !to_draw_.empty() || stream_.connection().failure(); });
      continue;
    }
    loop_.poll();
    if (auto drawn = draw_next(draw); !drawn) return drawn;
  }
  ended_ = Clock::now();
  return {};
}

void Flight::ask_next(const CameraPath& path, TimePoint now) {
  const double step = static_cast<double>(stream_.counters().asked) / options_.frames;
  stream_.ask(view_of(path.at(step * path.duration_seconds()), options_.size));
  pacer_.sent(now);
  last_asked_ = now;
}

void Flight::on_answer(const Answer& answer) {
  pacer_.answered(answer.response);
  if (answer.mask.complete()) latencies_.add(answer.response);
  to_draw_.push_back({answer.mask.frame.value - 1, answer.camera, answer.mask, answer.lights});
  covered_ += cover_.cover(to_draw_.back().mask);
}

Result<void> Flight::draw_next(const Draw& draw) {
  const FlownFrame frame = std::move(to_draw_.front());
  to_draw_.pop_front();
  if (frame.mask.grid.width != options_.size.traced_width() ||
      frame.mask.grid.height != options_.size.traced_height()) {
    return size_changed(frame.mask.grid);
  }
  const TimePoint before = Clock::now();
  auto drawn = draw(frame);
  drawing_ += Clock::now() - before;
  return drawn;
}

TimePoint Flight::next_event(TimePoint now) const {
  return all_asked() ? now + kTurn : std::min(now + kTurn, pacer_.next_send(stream_.in_flight()));
}

// The last camera's answer may never come: it is waited for as long as others took.
bool Flight::finished(TimePoint now) const {
  if (!all_asked() || !to_draw_.empty()) return false;
  return stream_.in_flight() == 0 || now - last_asked_ > pacer_.answer_patience();
}

FlightFigures Flight::figures() const {
  return {.counters = stream_.counters(),
          .latencies = latencies_,
          .seconds = to_seconds(ended_ - started_),
          .bytes = stream_.connection().data_counters().received_bytes,
          .draw_seconds = to_seconds(drawing_),
          .covered_words = covered_};
}

std::string Flight::progress_line(TimePoint now) const {
  const auto& counters = stream_.counters();
  char line[160];
  std::snprintf(line, sizeof line, "%5.1f s  %llu of %u frames asked for, %llu answered, p50 %.1f ms",
                to_seconds(now - started_), static_cast<unsigned long long>(counters.asked), options_.frames,
                static_cast<unsigned long long>(counters.complete + counters.incomplete),
                to_milliseconds(latencies_.percentile(0.5)));
  return line;
}

}  // namespace gnomon::client
