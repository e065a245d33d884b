#include "client/stream/moving_stream.h"

#include <algorithm>
#include <utility>

namespace gnomon::client {
namespace {

// Cameras that may still be answered.
uint64_t pending(const StreamCounters& c) {
  return c.asked - c.complete - c.incomplete - c.superseded - c.unanswered;
}

}  // namespace

MovingStream::MovingStream(Loop& loop, StreamOptions options, Events events)
    : loop_(loop),
      options_(std::move(options)),
      events_(std::move(events)),
      begin_timer_(loop, [this] { open_next(); }),
      retire_timer_(loop, [this] { retired_.reset(); }) {
  stream_ = make();
  number_ = made_;
}

std::unique_ptr<VisibilityStream> MovingStream::make() {
  const uint32_t number = ++made_;
  return std::make_unique<VisibilityStream>(
      loop_, options_,
      VisibilityStream::Events{
          .answer = [this, number](const Answer& answer) { on_answer(number, answer); },
          .opened = [this, number] { on_opened(number); },
          .message = [this, number](const protocol::Message& message) { on_message(number, message); },
          .closed = [this, number](const Error& error) { on_closed(number, error); }});
}

void MovingStream::close(const std::string& reason) {
  policy_.moved();
  begin_timer_.disarm();
  if (next_) next_->close(reason);
  stream_->close(reason);
}

void MovingStream::ask(const protocol::CameraView& camera, Nanoseconds display_deadline, uint32_t index) {
  newest_ = Newest{camera, display_deadline, index};
  if (next_ && next_->connection().state() == Connection::State::open) next_->ask(camera, display_deadline, index);
  stream_->ask(camera, display_deadline, index);
}

// The session to come is asked for the newest camera at once: the sooner it answers, the sooner it takes over, also
// where the client stands still.
void MovingStream::on_opened(uint32_t number) {
  if (number == 1) return events_.opened ? events_.opened() : void();
  VisibilityStream& opened = is_in_force(number) ? *stream_ : *next_;
  if (newest_) {
    opened.ask(newest_->camera, newest_->display_deadline, newest_->index);
    if (is_in_force(number)) --before_.asked;  // the session that has ended was asked for it, too
  }
  if (is_in_force(number)) announce_move();
}

void MovingStream::on_answer(uint32_t number, const Answer& answer) {
  if (!is_in_force(number)) {
    if (!answer.mask.complete()) return;
    take_over();
    announce_move();
  }
  if (answered_before_ && answer.index <= *answered_before_) {
    --(answer.mask.complete() ? before_.complete : before_.incomplete);
    return;
  }
  newest_answered_ = std::max(answer.index, newest_answered_.value_or(0));
  if (events_.answer) events_.answer(answer);
}

void MovingStream::on_message(uint32_t number, const protocol::Message& message) {
  if (!is_in_force(number)) {
    if (!std::holds_alternative<protocol::Waiting>(message)) told_next_[message.index()] = message;
    return;
  }
  if (const auto* draining = std::get_if<protocol::Draining>(&message)) on_drain(*draining);
  if (events_.message) events_.message(message);
}

void MovingStream::on_drain(const protocol::Draining& draining) {
  const auto wait = policy_.told(draining);
  if (wait) begin_timer_.arm(Clock::now() + *wait);
  if (policy_.wanted()) return;
  begin_timer_.disarm();
  give_up_next();
}

void MovingStream::open_next() {
  told_next_.clear();
  next_ = make();
}

void MovingStream::give_up_next() {
  if (!next_) return;
  next_->close("");
  retire(std::move(next_));
}

void MovingStream::on_closed(uint32_t number, const Error& error) {
  if (!is_in_force(number)) {
    const auto wait = policy_.wait_after(next_->connection().refusal());
    retire(std::move(next_));
    if (wait) begin_timer_.arm(Clock::now() + *wait);
    return;
  }
  begin_timer_.disarm();
  // A server that keeps its client out means all servers.
  if (!next_ && policy_.wanted() && !stream_->connection().refusal()) open_next();
  if (!next_) return events_.closed ? events_.closed(error) : void();
  const bool open = next_->connection().state() == Connection::State::open;
  take_over();
  if (open) announce_move();
}

// Precondition: there is a session to come. Cameras that it was asked for were asked of the one before, too.
void MovingStream::take_over() {
  policy_.moved();
  begin_timer_.disarm();
  stream_->close("moved to another server of the fleet");
  const StreamCounters& ended = stream_->counters();
  const uint64_t twice = next_->counters().asked;
  before_ += ended;
  before_.asked -= twice;
  before_.superseded += pending(ended) - std::min(pending(ended), twice);
  ++before_.moved;
  answered_before_ = newest_answered_;
  bytes_before_ += stream_->connection().data_counters().received_bytes;
  retire(std::move(stream_));
  stream_ = std::move(next_);
  number_ = made_;
}

void MovingStream::announce_move() {
  if (events_.moved) events_.moved();
  for (const auto& [kind, message] : std::exchange(told_next_, {})) on_message(number_, message);
}

// Whoever calls may have been called by the stream, which therefore ends a little later.
void MovingStream::retire(std::unique_ptr<VisibilityStream> stream) {
  retired_ = std::move(stream);
  retire_timer_.arm(Clock::now());
}

StreamCounters MovingStream::counters_at_end() const {
  StreamCounters sum = counters();
  const uint64_t settled = sum.complete + sum.incomplete + sum.superseded + sum.unanswered;
  const uint64_t waiting = sum.asked - std::min(sum.asked, settled);
  const uint64_t newer_than_answered = std::min<uint64_t>(in_flight(), waiting);
  sum.unanswered += newer_than_answered;
  sum.superseded += waiting - newer_than_answered;
  return sum;
}

StreamCounters MovingStream::counters() const {
  StreamCounters sum = before_;
  sum += stream_->counters();
  return sum;
}

uint64_t MovingStream::received_bytes() const {
  const uint64_t of_next = next_ ? next_->connection().data_counters().received_bytes : 0;
  return bytes_before_ + stream_->connection().data_counters().received_bytes + of_next;
}

}  // namespace gnomon::client
