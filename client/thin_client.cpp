#include "client/thin_client.h"

#include <utility>

namespace gnomon::client {

ThinClient::ThinClient(Loop& loop, ThinClientOptions options, Events events)
    : loop_(loop),
      options_(std::move(options)),
      events_(std::move(events)),
      order_(options_.mode, options_.mode == Mode::automatic ? std::move(options_.automatic)
                                                             : std::make_unique<FixedPrediction>(options_.ahead)),
      retry_(loop, [this] { connect(); }) {
  connect();
}

ThinClient::~ThinClient() { close(""); }

void ThinClient::connect() {
  if (stream_) {
    counters_before_ += stream_->counters_at_end();
    bytes_before_ += stream_->received_bytes();
  }
  stream_ = std::make_unique<MovingStream>(
      loop_, options_.stream,
      MovingStream::Events{.answer = [this](const Answer& answer) { on_answer(answer); },
                           .opened =
                               [this] {
                                 reconnects_ += opened_once_;
                                 opened_once_ = true;
                                 ended_.reset();
                                 reconnect_.connected();
                               },
                           .message =
                               [this](const protocol::Message& message) {
                                 if (events_.message) events_.message(message);
                               },
                           .closed = [this](const Error& error) { on_closed(error); }});
}

// A first connection that fails is reported to the caller; one that is lost later is replaced. Where the server refuses
// that, why it ended the one before says more, as that a token was revoked: the refusal tells of strangers only.
void ThinClient::on_closed(const Error& error) {
  const auto wait = stream_ ? reconnect_.wait_after(stream_->connection().refusal()) : std::nullopt;
  if (closed_ || !opened_once_ || !options_.reconnect || !wait) {
    failure_ = ended_ ? Error{ended_->message + "; and a new one: " + error.message} : error;
    return;
  }
  const bool was_open = stream_->connection().welcome().session != SessionId{} || stream_->counters().moved > 0;
  if (was_open) ended_ = error;
  if (was_open && events_.lost) events_.lost(error);
  retry_.arm(Clock::now() + *wait);
}

Result<void> ThinClient::wait_open() {
  loop_.run_until(TimePoint::max(), [this] { return online() || failure_; });
  if (failure_) return *failure_;
  return {};
}

void ThinClient::look(const protocol::CameraView& camera, Nanoseconds display_deadline) {
  const uint32_t index = order_.asked_count();
  order_.asked(camera, Clock::now());
  if (!online()) return;
  stream_->ask(camera, display_deadline, index);
}

void ThinClient::on_answer(const Answer& answer) {
  auto received = std::make_shared<const ReceivedMasks>(
      ReceivedMasks{answer.index, answer.camera, answer.mask, answer.lights, answer.response});
  if (events_.received) events_.received(*received);
  if (order_.answered(received->index, Clock::now())) seen_ = std::move(received);
}

std::optional<Showing> ThinClient::next() {
  const TimePoint now = Clock::now();
  const auto shown = order_.next(now);
  if (!shown) return std::nullopt;
  return Showing{.index = shown->camera.index,
                 .newest = shown->newest,
                 .camera = shown->camera.camera,
                 .seen = seen_,
                 .reprojected = shown->reprojected,
                 .age = now - shown->camera.asked};
}

StreamCounters ThinClient::counters() const {
  StreamCounters sum = counters_before_;
  sum += stream_->counters();
  return sum;
}

uint64_t ThinClient::received_bytes() const { return bytes_before_ + stream_->received_bytes(); }

void ThinClient::close(const std::string& reason) {
  closed_ = true;
  retry_.disarm();
  stream_->close(reason);
}

}  // namespace gnomon::client
