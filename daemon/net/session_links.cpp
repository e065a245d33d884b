#include "daemon/net/session_links.h"

#include "common/within_memory.h"
#include "daemon/net/control_sender.h"

namespace gnomon::daemon {
namespace {

// Whether a frame had spent more of the time in which it was of use before it came to the link than it then had left.
bool came_late(const FrameTimes& times) {
  return times.deadline != TimePoint::max() && times.encoded - times.arrival > times.deadline - times.encoded;
}

constexpr auto kLaterTurn = std::chrono::milliseconds(10);  // of a session for which there was no memory

}  // namespace

SessionLinks::SessionLinks(const NetShared& shared, OpenSessions& sessions, asio::io_context& io)
    : shared_(shared), sessions_(sessions), io_(io) {}

Result<void> SessionLinks::open(const asio::ip::udp::endpoint& local) {
  auto socket = DataSocket::open(io_, local);
  if (!socket) return socket.error();
  data_ = std::move(*socket);
  web_transport_.listen(
      {[this](Session& session, const protocol::Data& data) { receive(session, data, Way::web_transport); },
       [this](Session& session) { serve(session); }});
  return web_transport_.open(*data_);
}

void SessionLinks::start() {
  data_->start([this](auto datagram, const auto& from) { receive(datagram, from); });
}

void SessionLinks::close() {
  web_transport_.close();
  data_->close();
}

void SessionLinks::receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from) {
  Metrics& metrics = shared_.metrics;
  metrics.datagram_received();
  if (web_transport_.receive(datagram, from)) return;
  if (datagram.size() > protocol::kMaxDatagramBytes) return metrics.report(Fault::datagram_too_long);
  const auto header = protocol::decode_header(datagram);
  if (!header) return metrics.report(Fault::datagram_header);
  Session* session = sessions_.find(header->session);
  if (!session) return metrics.report(Fault::datagram_session);
  const TimePoint now = Clock::now();
  const DatagramOutcome received = session->receive(datagram, from, now);
  handle_fault(*session, received);
  if (!received.opened || received.ends_session()) return;
  if (received.ping) sender_.answer_ping(*session, *data_, from, now);
  if (received.view) request(*session, *received.view);
  serve(*session);
}

void SessionLinks::receive(Session& session, const protocol::Data& data, Way way) {
  const DatagramOutcome received = session.receive(data, Clock::now(), way);
  handle_fault(session, received);
  if (received.ends_session()) return;
  if (received.view) request(session, *received.view);
  serve(session);
}

// The session may have been closed afterwards.
void SessionLinks::handle_fault(const Session& session, const DatagramOutcome& received) {
  if (!received.fault) return;
  shared_.metrics.report(session.grant().tenant, session.id(), *received.fault);
  if (received.ends_session() && ends_) ends_(session.id(), row_of(*received.fault).event);
}

void SessionLinks::on_room(SessionId id) {
  if (Session* const session = sessions_.find(id)) serve(*session);
}

void SessionLinks::request(const Session& session, const ViewRequest& view) {
  const TenantId tenant = session.grant().tenant;
  shared_.metrics.views_received(tenant, 1 + view.coalesced);
  for (uint32_t i = 0; i < view.coalesced; ++i) shared_.metrics.coalesced(tenant);
  if (!shared_.devices.push_view(view)) shared_.metrics.dropped(tenant, session.id(), Fault::view_queue_full);
}

void SessionLinks::send(EncodedFrame& frame) {
  const FrameRoute& route = frame.meta.route;
  Session* session = sessions_.find(route.session);
  // A frame may be ready before the client's address is validated: it waits in the link.
  const bool wanted = session && (sessions_.is_reachable(*session) || session->path().is_pending()) &&
                      (sessions_.stream_of(route.session) || session->notified_shape().is_of(frame.meta.spec));
  if (!wanted) return shared_.metrics.dropped(route.tenant, route.session, Fault::session_gone);
  const size_t bytes = sender_.add(frame, *session, Clock::now());
  session->under_way().add(frame.meta, bytes);
  serve(*session);
}

// Called after each change: sends challenges and what the link releases, requests a view that was held back, and sets
// the time of the next call.
void SessionLinks::serve(Session& session) {
  const TimePoint now = Clock::now();
  sender_.send_challenges(session, *data_, now);
  if (session.path().take_failure(now)) {
    shared_.metrics.report(session.grant().tenant, session.id(), Fault::path_unproven);
  }
  if (!sessions_.is_reachable(session)) return wake(session.id(), session.path().wake_at());
  const bool has_room = send_what_waits(session, now);
  while (const auto ended = session.under_way().take_ended()) finish(session, *ended, now);
  if (const auto view = session.views().take(now)) request(session, *view);
  // Without room, the link and what is held back for it are served when there is some.
  const TimePoint link =
      has_room ? std::min(session.link().wake_at(now), session.views().take_at(now)) : TimePoint::max();
  wake(session.id(), std::min(link, session.path().wake_at()));
}

// False if the way takes no more for now. Precondition: the session is reachable.
bool SessionLinks::send_what_waits(Session& session, TimePoint now) {
  switch (session.way()) {
    case Way::control: return send_over_control(session, *sessions_.stream_of(session.id()), now);
    case Way::web_transport: return web_transport_.send(session, now);
    case Way::datagrams: break;
  }
  if (const auto fault = sender_.send(session, *data_, now)) {
    shared_.metrics.dropped(session.grant().tenant, session.id(), *fault);
  }
  return true;
}

void SessionLinks::wake(SessionId id, TimePoint when) {
  timers_.set(id, when);
  arm_timer();
}

void SessionLinks::finish(Session& session, const FramesUnderWay::Ended& ended, TimePoint now) {
  const TenantId tenant = session.grant().tenant;
  const FrameMeta& meta = ended.meta;
  const size_t bytes = ended.bytes + session.link().take_extra_bytes();
  shared_.devices.sent(meta.route.device,
                       {tenant, meta.route.scene, meta.spec.traced_bits, bytes, meta.spec.samples});
  if (!ended.complete) {
    const Fault why = came_late(meta.times) ? Fault::deadline_unreachable : Fault::link_too_slow;
    return shared_.metrics.dropped(tenant, session.id(), why);
  }
  session.totals().add(meta, now);
  shared_.metrics.links().transports.sent(sessions_.transport_of(session), bytes);
  shared_.metrics.frame_sent(tenant, session.grant().scene_name, meta, now, bytes);
}

void SessionLinks::arm_timer() {
  const TimePoint next = timers_.next();
  if (next >= armed_) return;
  armed_ = next;
  until_memory_suffices([&] {
    timer_.expires_at(next);
    timer_.async_wait([this](const asio::error_code& error) {
      if (!error) serve_due();
    });
  });
}

void SessionLinks::serve_due() {
  armed_ = TimePoint::max();
  const TimePoint now = Clock::now();
  for (SessionId id; timers_.take(now, id);) {
    Session* const session = sessions_.find(id);
    if (!session) continue;
    const bool served = done_or_dropped("a session's turn", [&] { serve(*session); });
    if (!served) until_memory_suffices([&] { timers_.set(id, now + kLaterTurn); });
  }
  arm_timer();
}

}  // namespace gnomon::daemon
