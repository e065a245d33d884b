// How a session goes on, without a control connection too, and how it ends.
#include "daemon/net/net_thread.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr auto kShowOutTime = 1s;  // for a client to read our last words and close

}  // namespace

void NetThread::hear_client(SessionId id, Result<protocol::Message> message) {
  if (!message) return close_session(id, message.error().message);
  if (std::holds_alternative<protocol::Bye>(*message)) return close_session(id, "the client said Bye");
  if (const auto* data = std::get_if<protocol::Data>(&*message)) return hear_data(id, *data);
  close_session(id, "the client sent a message that only servers send");
}

ControlStream* NetThread::stream_of(SessionId id) const {
  const auto found = streams_.find(id);
  return found == streams_.end() ? nullptr : found->second.get();
}

// A client that may resume its session is served on, for as long as one that says nothing.
void NetThread::lose_control(SessionId id, const std::string& why) {
  Session& session = *sessions_.find(id);
  if (!session.resumable() || shared_.health.draining) return close_session(id, why);
  streams_.erase(id);
  session.control_lost(Clock::now() + shared_.config.server.silence_timeout);
  if (!has_way(session)) wakes_.remove(id);
  log::info("control connection lost",
            {{"session", id.value}, {"tenant", shared_.roster.get()->name(session.grant().tenant)}, {"why", why}});
}

void NetThread::close_session(SessionId id, const std::string& why) {
  Session* const session = sessions_.find(id);
  if (!session) return;
  session->forget();
  const auto stream = drop_session(id, why);
  if (!stream) return;
  stream->send(protocol::Bye{why});
  show_out(stream);
}

// To be resumed elsewhere.
void NetThread::leave_session(SessionId id, const std::string& why) {
  if (!sessions_.find(id)) return;
  if (const auto stream = drop_session(id, why)) show_out(stream);
}

// What it was controlled by, if there is something left to say.
std::shared_ptr<ControlStream> NetThread::drop_session(SessionId id, const std::string& why) {
  Session& session = *sessions_.find(id);
  const TenantId tenant = session.grant().tenant;
  const protocol::Stats totals = session.take_stats();
  log::info("session closed", {{"session", id.value},
                               {"tenant", shared_.roster.get()->name(tenant)},
                               {"why", why},
                               {"frames", totals.frames},
                               {"coalesced", totals.coalesced}});
  shared_.metrics.session_closed(tenant);
  shared_.devices.close(id);
  shared_.metrics.link(session.take_link_report());
  wakes_.remove(id);
  std::shared_ptr<ControlStream> stream;
  if (const auto found = streams_.find(id); found != streams_.end()) {
    stream = std::move(found->second);
    streams_.erase(found);
  }
  sessions_.remove(id);
  return stream;
}

void NetThread::show_out(const std::shared_ptr<ControlStream>& stream) {
  stream->finish();
  for (const Visitor& pushed_out : lobby_.enter({stream, Clock::now() + kShowOutTime, true})) {
    pushed_out.stream->close();
  }
}

}  // namespace gnomon::daemon
