#include "client/view/flight.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "client/prediction/error_balance.h"

namespace gnomon::client {
namespace {

using namespace std::chrono_literals;

constexpr Nanoseconds kFirstAnswerPatience = std::chrono::seconds(60);
constexpr auto kTurn = 100ms;  // how often conditions without an event of their own are checked

PaceOptions pace_of(const FlightOptions& options, float granted_hz) {
  double rate = options.rate_hz;
  if (granted_hz > 0 && (rate <= 0 || rate > static_cast<double>(granted_hz)))
    rate = static_cast<double>(granted_hz);
  return {.rate_hz = rate, .max_in_flight = max_in_flight(options.mode)};
}

ThinClientOptions client_options(const FlightOptions& options) {
  ThinClientOptions client;
  client.stream = options.stream;
  client.mode = options.mode;
  client.ahead = options.ahead;
  client.automatic =
      std::make_unique<ErrorBalance>(ErrorBalanceOptions{.size = options.size, .cost_per_s = options.cost_per_s});
  return client;
}

Error size_changed(const TileGrid& grid) {
  return Error{"the server offers " + std::to_string(grid.width) + "x" + std::to_string(grid.height) +
               " (border included) at the moment: ask for that size"};
}

bool fits(const TileGrid& grid, const ViewSize& size) {
  return grid.width == size.traced_width() && grid.height == size.traced_height();
}

}  // namespace

Flight::Flight(FlightOptions options)
    : options_(std::move(options)),
      pacer_({}, Clock::now()),
      client_(loop_, client_options(options_),
              {.received = [this](const ReceivedMasks& received) { on_received(received); },
               .message = options_.message,
               .lost =
                   [](const Error& why) {
                     std::fprintf(stderr, "connection lost, connecting again: %s\n", why.message.c_str());
                   }}) {}

Result<void> Flight::open() {
  if (auto opened = client_.wait_open(); !opened) return opened;
  if (!fits(client_.grid(), options_.size)) return size_changed(client_.grid());
  if (client_.grid().planes == 0)
    return Error{"scene '" + client_.scene().name + "' has no lights: there is nothing to ask for"};
  return {};
}

bool Flight::kept_out() const {
  const auto& refusal = client_.refusal();
  return refusal && refusal->code == protocol::RefusalCode::kept_out;
}

Result<void> Flight::fly(const CameraPath& path, const Draw& draw, Progress& progress) {
  started_ = Clock::now();
  pacer_ = CameraPacer(pace_of(options_, welcome().rate_hz), started_);
  for (TimePoint now = started_; !finished(now) && !options_.interrupted(); now = Clock::now()) {
    if (client_.failure()) return *client_.failure();
    const bool ask = may_ask(now);
    if (ask) ask_next(path, now);
    if (progress.due(now)) progress.show(progress_line(now), now);
    if (ask || draws_on_masks()) {
      loop_.poll();
      // Nothing more is to come: without a GPU the last drawing may take longer than the server bears silence.
      if (all_asked() && client_.in_flight() == 0) close();
      if (const auto drawn = draw_next(draw); !drawn) return drawn;
      continue;
    }
    loop_.run_until(next_event(now), [this] {
      return client_.failure() || options_.interrupted() || draws_on_masks() ||
             (new_masks_ && may_ask(Clock::now()));
    });
  }
  ended_ = Clock::now();
  return {};
}

// A client that predicts draws at each of its cameras; one that waits, and at the end any, draws when masks arrive.
bool Flight::draws_on_masks() const { return new_masks_ && (waits_for_masks(options_.mode) || all_asked()); }

bool Flight::may_ask(TimePoint now) const {
  if (all_asked() || !client_.online()) return false;
  if (options_.mode == Mode::sequential && new_masks_) return false;
  return pacer_.next_send(client_.in_flight()) <= now;
}

// The border lies where the camera will be when the masks arrive, if it moves on as between the last two steps.
BorderPlace Flight::border_place(const CameraPath& path, double seconds, double step) const {
  if (!options_.border_by_motion) return centred(options_.size);
  const scenes::CameraPose now = path.at(seconds), before = path.at(std::max(0.0, seconds - step));
  const auto frames_away = static_cast<float>(client_.in_flight() + 1);
  return towards(options_.size, now, extrapolate(before, now, frames_away));
}

void Flight::ask_next(const CameraPath& path, TimePoint now) {
  const double step = path.duration_seconds() / options_.frames;
  const double seconds = step * asked_++;
  client_.look(view_of(path.at(seconds), options_.size, border_place(path, seconds, step)));
  pacer_.sent(now);
  last_asked_ = now;
}

void Flight::on_received(const ReceivedMasks& received) {
  pacer_.answered(received.response);
  if (received.mask.complete()) figures_.latencies.add(received.response);
  new_masks_ = true;
}

Result<void> Flight::draw_next(const Draw& draw) {
  new_masks_ = false;
  const auto showing = client_.next();
  if (!showing) return {};
  if (!fits(showing->seen->mask.grid, options_.size)) return size_changed(showing->seen->mask.grid);
  figures_.ages.add(showing->age);
  figures_.frames_ahead += showing->ahead();
  ++figures_.shown;
  const TimePoint before = Clock::now();
  const auto drawn = draw(*showing);
  drawing_ += Clock::now() - before;
  return drawn;
}

// Without a session the loop has to run, because the loop is what reconnects.
TimePoint Flight::next_event(TimePoint now) const {
  if (all_asked() || !client_.online()) return now + kTurn;
  return std::min(now + kTurn, pacer_.next_send(client_.in_flight()));
}

// The last camera's answer may never arrive: it is waited for as long as others took. If there were no others, a busy
// server may be preparing its first frame.
bool Flight::finished(TimePoint now) const {
  if (!all_asked() || new_masks_) return false;
  const Nanoseconds patience = pacer_.any_answer() ? pacer_.answer_patience() : kFirstAnswerPatience;
  return client_.in_flight() == 0 || now - last_asked_ > patience;
}

FlightStats Flight::figures() const {
  FlightStats figures = figures_;
  figures.counters = client_.counters();
  figures.pending = client_.in_flight();
  figures.seconds = to_seconds(ended_ - started_);
  figures.bytes = client_.received_bytes();
  figures.draw_seconds = to_seconds(drawing_);
  figures.reconnects = client_.reconnects();
  return figures;
}

std::string Flight::progress_line(TimePoint now) const {
  const StreamCounters counters = client_.counters();
  char line[200];
  std::snprintf(line, sizeof line,
                "%5.1f s  %u of %u frames asked for, %llu answered, p50 %.1f ms; shown %llu, %.1f ms old, x %.1f%s",
                to_seconds(now - started_), asked_, options_.frames,
                static_cast<unsigned long long>(counters.complete + counters.incomplete),
                to_milliseconds(figures_.latencies.percentile(0.5)),
                static_cast<unsigned long long>(figures_.shown), to_milliseconds(figures_.ages.percentile(0.5)),
                figures_.mean_ahead(), client_.online() ? "" : "; no server, trying again");
  return line;
}

}  // namespace gnomon::client
