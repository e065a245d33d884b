#include "daemon/net/session_control.h"

#include <asio/post.hpp>

#include <algorithm>

#include "gpu/wire/translate.h"

namespace gnomon::daemon {

using namespace std::chrono_literals;

SessionControl::SessionControl(const NetShared& shared, uint32_t net_thread, asio::io_context& io,
                               OpenSessions& sessions, SessionLinks& links, PendingConnections& pending)
    : shared_(shared), net_thread_(net_thread), io_(io), sessions_(sessions), links_(links), pending_(pending) {
  links_.when_ended([this](SessionId id, const std::string& why) { close(id, why); });
}

const Session& SessionControl::open(SessionParts parts, const std::shared_ptr<ControlStream>& stream) {
  const SessionId id = parts.id;
  if (parts.stored) {
    parts.stored.when_wanted([this, id] {
      asio::post(io_, [this, id] { leave(id, "its client has come back on another connection"); });
    });
  }
  const Session& session = sessions_.add(std::make_unique<Session>(std::move(parts), Clock::now()), stream);
  stream->listen([this, id](const Result<protocol::Message>& message) { on_control_message(id, message); },
                 [this, id](Fault, const std::string& why) { on_control_lost(id, why); });
  stream->when_room([this, id] { links_.on_room(id); });
  shared_.devices.open({.session = id,
                        .grant = session.grant(),
                        .net_thread = net_thread_,
                        .references = session.references(),
                        .generation = session.generation()});
  shared_.metrics.session_opened(session.grant().tenant);
  return session;
}

void SessionControl::on_control_message(SessionId id, const Result<protocol::Message>& message) {
  if (!message) return close(id, message.error().message);
  if (std::holds_alternative<protocol::Bye>(*message)) {
    if (moving_.erase(id) > 0) shared_.metrics.operation().moved(SessionMove::left);
    sessions_.find(id)->forget();
    return leave(id, "the client said Bye");  // nothing is said after it
  }
  if (const auto* data = std::get_if<protocol::Data>(&*message)) return links_.receive(*sessions_.find(id), *data);
  close(id, "the client sent a message that has no place in a session");
}

// A session that can be resumed is served without its control connection for server.silence_timeout.
void SessionControl::on_control_lost(SessionId id, const std::string& why) {
  Session& session = *sessions_.find(id);
  if (!session.resumable() || shared_.health.stopping) return close(id, why);
  sessions_.take_stream(id);
  session.resumed_until() = Clock::now() + shared_.config.server.silence_timeout;
  if (!sessions_.is_reachable(session)) links_.pause(id);
  log::info("control connection lost",
            {{"session", id.value}, {"tenant", shared_.tenants.get()->name(session.grant().tenant)}, {"why", why}});
}

void SessionControl::kick(SessionId id, const Kick& kick) {
  const Session* const session = sessions_.find(id);
  if (!session) return;
  if (kick.stay_out.count() > 0) {
    shared_.kept_out.keep(session->grant().tenant, session->permit().network(), kick.why,
                          Clock::now() + kick.stay_out);
  }
  close(id, kick.why, kick.stay_out);
}

void SessionControl::close(SessionId id, const std::string& why, std::chrono::milliseconds stay_out) {
  Session* const session = sessions_.find(id);
  if (!session) return;
  session->forget();
  const auto stream = drop(id, why);
  if (!stream) return;
  stream->send(protocol::Bye{why, static_cast<uint32_t>(stay_out.count())});
  pending_.close_gracefully(stream, Clock::now());
}

// Ends the session here without a word; where it was not forgotten, it can be resumed elsewhere.
void SessionControl::leave(SessionId id, const std::string& why) {
  if (!sessions_.find(id)) return;
  if (const auto stream = drop(id, why)) pending_.close_gracefully(stream, Clock::now());
}

// Removes the session. Returns the connection that controlled it, nullptr if it had none.
std::shared_ptr<ControlStream> SessionControl::drop(SessionId id, const std::string& why) {
  Session& session = *sessions_.find(id);
  const TenantId tenant = session.grant().tenant;
  if (moving_.erase(id) > 0) shared_.metrics.operation().moved(SessionMove::stayed);
  const protocol::Stats totals = session.totals().take_stats();
  log::info("session closed", {{"session", id.value},
                               {"tenant", shared_.tenants.get()->name(tenant)},
                               {"why", why},
                               {"frames", totals.frames},
                               {"coalesced", totals.coalesced}});
  shared_.metrics.session_closed(tenant);
  shared_.devices.close(id);
  shared_.metrics.links().count(session.take_link_report());
  links_.forget(id);
  auto stream = sessions_.take_stream(id);
  sessions_.remove(id);
  return stream;
}

void SessionControl::close_silent(TimePoint now) {
  for (const SessionId id : sessions_.table().silent_since(now - shared_.config.server.silence_timeout)) {
    close(id, "silent");
  }
  for (const SessionId id : sessions_.table().not_resumed(now)) {
    close(id, "its control connection did not come back");
  }
}

void SessionControl::close_unwelcome() {
  std::vector<std::pair<SessionId, std::string>> unwelcome;
  for (const auto& [id, session] : sessions_.table()) {
    if (auto why = objection_to(session->grant(), shared_)) unwelcome.emplace_back(id, std::move(*why));
  }
  for (const auto& [id, why] : unwelcome) close(id, why);
}

void SessionControl::end_all(bool for_good) {
  while (sessions_.table().size() > 0) {
    const SessionId id = sessions_.table().begin()->first;
    if (for_good || !sessions_.find(id)->resumable()) {
      close(id, "the server is stopping");
    } else {
      leave(id, "the server is stopping and may come back");
    }
  }
}

void SessionControl::notify(const SessionDegraded& degraded) {
  Session* const session = sessions_.find(degraded.session);
  ControlStream* const stream = sessions_.stream_of(degraded.session);
  if (!session || !stream || session->generation() != degraded.generation) return;
  stream->send(degraded.message);
  const SampleCounts samples = sample_counts_of(std::max<uint8_t>(degraded.message.samples, 1));
  session->notified_shape() = {degraded.message.width, degraded.message.height, samples, degraded.message.rate_hz,
                               static_cast<uint32_t>(degraded.message.untraced_lights.size())};
}

void SessionControl::announce_drain(std::chrono::milliseconds deadline) {
  for (const auto& [id, stream] : sessions_.streams()) {
    tell_to_go(id, *stream, {static_cast<uint32_t>(deadline.count()), protocol::Draining::kMoveNow});
  }
  for (const SessionId id : sessions_.table().not_resumed(TimePoint::max() - 1ns)) {
    close(id, "without a control connection when the server went away");
  }
}

void SessionControl::ask_to_move(bool move) {
  for (const auto& [id, stream] : sessions_.streams()) ask_to_move(id, move);
}

void SessionControl::ask_to_move(SessionId id, bool move) {
  ControlStream* const stream = sessions_.stream_of(id);
  if (!stream || !sessions_.find(id)->grant().has(protocol::kFeatureFleet)) return;
  const uint8_t flags = move ? protocol::Draining::kMoveNow : 0;
  tell_to_go(id, *stream, {protocol::Draining::kNoDeadline, flags});
}

// Only a client of a fleet is asked to move: others have no door to ask, and do not know the flag.
void SessionControl::tell_to_go(SessionId id, ControlStream& stream, protocol::Draining message) {
  if (!sessions_.find(id)->grant().has(protocol::kFeatureFleet)) message.flags = 0;
  if (!message.move_now()) {
    if (moving_.erase(id) > 0) shared_.metrics.operation().moved(SessionMove::kept);
  } else if (moving_.insert(id).second) {
    shared_.metrics.operation().moved(SessionMove::asked);
  }
  stream.send(message);
}

void SessionControl::announce_lights(const LightsUpdate& update) {
  const protocol::LightsChanged message{gpu::to_wire(update.lights), update.version};
  for (const auto& [id, stream] : sessions_.streams()) {
    if (sessions_.find(id)->grant().scene_name == update.scene) stream->send(message);
  }
}

}  // namespace gnomon::daemon
