// What goes through the sessions' links: views in as far as the link has room for their frames, frames out at its pace.
#include "daemon/net/control_sender.h"
#include "daemon/net/net_thread.h"

namespace gnomon::daemon {

void NetThread::ask(const Session& session, const ViewRequest& view) {
  const TenantId tenant = session.grant().tenant;
  for (uint32_t i = 0; i < view.coalesced; ++i) shared_.metrics.coalesced(tenant);
  if (!shared_.devices.push_view(view)) shared_.metrics.dropped(tenant, session.id(), Fault::view_queue_full);
}

void NetThread::hear_data(SessionId id, const protocol::Data& data) {
  Session& session = *sessions_.find(id);
  const Received received = session.receive(data, Clock::now());
  if (received.fault) shared_.metrics.report(session.grant().tenant, id, *received.fault);
  if (received.view) ask(session, *received.view);
  serve(session);
}

// To somewhere that the client has spoken from.
bool NetThread::has_way(const Session& session) const {
  return session.by_control() ? stream_of(session.id()) != nullptr : session.address().has_value();
}

void NetThread::send(EncodedFrame& frame) {
  Session* session = sessions_.find(frame.meta.route.session);
  if (!session || !has_way(*session) || !(stream_of(session->id()) || session->expects(frame.meta.spec.grid)))
    return shared_.metrics.dropped(frame.meta.route.tenant, frame.meta.route.session, Fault::session_gone);
  const size_t bytes = sender_.add(frame, *session, Clock::now());
  session->sending(frame.meta, bytes);
  serve(*session);
}

// After whatever changed: sends what may go, asks for the view that was kept back, and comes back in time.
void NetThread::serve(Session& session) {
  const TimePoint now = Clock::now();
  ControlStream* const stream = session.by_control() ? stream_of(session.id()) : nullptr;
  if (!has_way(session)) return wakes_.remove(session.id());  // its next word brings it back
  const auto fault = stream ? send_over_control(session, *stream, now) : sender_.send(session, *data_, now);
  if (fault) shared_.metrics.dropped(session.grant().tenant, session.id(), *fault);
  while (const auto ended = session.take_ended()) finish(session, *ended, now);
  if (const auto view = session.take_kept(now)) ask(session, *view);
  wakes_.set(session.id(), std::min(session.link().wake_at(now), session.kept_until(now)));
  arm_wakes();
}

void NetThread::finish(Session& session, const Session::Ended& ended, TimePoint now) {
  const TenantId tenant = session.grant().tenant;
  const size_t bytes = ended.bytes + session.link().take_extra_bytes();
  shared_.devices.sent(ended.meta.route.device,
                       {tenant, ended.meta.route.scene, ended.meta.spec.traced_bits(), bytes});
  if (!ended.whole) return shared_.metrics.dropped(tenant, session.id(), Fault::link_too_slow);
  session.frame_sent(ended.meta, now);
  shared_.metrics.frame_sent(tenant, session.grant().scene_name, ended.meta, now, bytes);
}

void NetThread::arm_wakes() {
  const TimePoint next = wakes_.next();
  if (next >= armed_) return;
  armed_ = next;
  wake_timer_.expires_at(next);
  wake_timer_.async_wait([this](const asio::error_code& error) {
    if (!error) wake();
  });
}

void NetThread::wake() {
  armed_ = TimePoint::max();
  const TimePoint now = Clock::now();
  for (SessionId id; wakes_.take(now, id);) {
    if (Session* session = sessions_.find(id)) serve(*session);
  }
  arm_wakes();
}

}  // namespace gnomon::daemon
