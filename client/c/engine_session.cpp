#include "client/c/engine_session.h"

#include <algorithm>
#include <utility>

namespace gnomon::client::c {

EngineSession::EngineSession(ThinClientOptions options)
    : client_(loop_, std::move(options),
              {.message = [this](const protocol::Message& message) { on_message(message); }}) {}

EngineSession::State EngineSession::state() const {
  if (closed_) return State::closed;
  if (client_.failure()) return State::failed;
  if (client_.online()) return State::open;
  return opened_ > 0 ? State::lost : State::connecting;
}

void EngineSession::serve(uint32_t timeout_ms, const std::function<bool()>& done) {
  if (timeout_ms == 0) {
    loop_.poll();
  } else {
    loop_.run_until(Clock::now() + std::chrono::milliseconds(timeout_ms), done);
  }
  learn();
}

uint32_t EngineSession::look(const protocol::CameraView& camera) {
  client_.look(camera);
  return looked_++;
}

std::shared_ptr<const ReceivedMasks> EngineSession::next() {
  const auto showing = client_.next();
  if (!showing) return nullptr;
  ++given_;
  return showing->seen;
}

void EngineSession::close(const std::string& reason) {
  closed_ = true;
  client_.close(reason);
}

// Resets `server_` if a session has been opened or resumed since: what was reported before is void.
void EngineSession::learn() {
  if (!client_.online()) return;
  const StreamCounters counters = client_.counters();
  const uint64_t opened = 1 + client_.reconnects() + counters.resumed + counters.moved;
  if (opened == opened_) return;
  opened_ = opened;
  const protocol::Welcome& welcome = client_.welcome();
  const TileGrid grid = client_.grid();
  server_ = ServerState{.revision = server_.revision + 1,
                        .welcome = welcome,
                        .scene = client_.scene(),
                        .lights_version = welcome.lights_version,
                        .width = grid.width,
                        .height = grid.height,
                        .rate_hz = welcome.rate_hz,
                        .degraded = {},
                        .draining_ms = 0,
                        .samples = sample_counts_of(std::max<uint8_t>(welcome.samples, 1)),
                        .stats = {}};
}

void EngineSession::on_message(const protocol::Message& message) {
  learn();
  if (const auto* stats = std::get_if<protocol::Stats>(&message)) {
    server_.stats = *stats;
  } else if (const auto* draining = std::get_if<protocol::Draining>(&message)) {
    server_.draining_ms = draining->deadline_ms == protocol::Draining::kNoDeadline ? 0 : draining->deadline_ms;
  } else if (const auto* degraded = std::get_if<protocol::Degraded>(&message)) {
    on_degraded(*degraded);
  } else if (const auto* lights = std::get_if<protocol::LightsChanged>(&message)) {
    server_.lights_version = lights->version;
    server_.scene = client_.scene();
    ++server_.revision;
  } else if (std::holds_alternative<protocol::SceneChanged>(message)) {
    server_.scene = client_.scene();
    ++server_.revision;
  }
}

void EngineSession::on_degraded(const protocol::Degraded& degraded) {
  const TileGrid grid = client_.grid();
  server_.width = grid.width;
  server_.height = grid.height;
  server_.rate_hz = degraded.rate_hz;
  if (degraded.samples > 0) server_.samples = sample_counts_of(degraded.samples);
  const bool whole = grid.width == server_.welcome.width && grid.height == server_.welcome.height &&
                     degraded.rate_hz == server_.welcome.rate_hz && degraded.untraced_lights.empty() &&
                     (degraded.samples == 0 || degraded.samples == server_.welcome.samples);
  server_.degraded = whole ? std::string() : degraded.reason;
}

}  // namespace gnomon::client::c
