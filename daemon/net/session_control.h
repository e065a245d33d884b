// How the sessions of a net thread begin, what their control connections say, how they go on without one, and how they
// end.
#pragma once

#include <asio/io_context.hpp>

#include <chrono>
#include <memory>
#include <string>

#include "daemon/net/lobby.h"
#include "daemon/net/session_links.h"

namespace gnomon::daemon {

// The net thread's. Outlived by what it refers to.
class SessionControl {
 public:
  // `net_thread`: the index of this net thread.
  SessionControl(const NetShared& shared, uint32_t net_thread, asio::io_context& io, OpenSessions& sessions,
                 SessionLinks& links, Lobby& lobby);

  // The session is served from now on, and controlled by `stream`, which has left the lobby.
  const Session& open(SessionParts parts, const std::shared_ptr<ControlStream>& stream);

  // The client is told why, and nobody resumes the session. No effect if there is no such session.
  void close(SessionId id, const std::string& why);
  // Those that have said nothing for too long, or whose client has not come back to resume them.
  void close_silent(TimePoint now);
  void close_closed_tenants();  // the sessions of tenants that the roster has closed

  // Every session ends: closed if `for_good` or if it cannot be resumed, else left to be resumed elsewhere.
  void end_all(bool for_good);

  // Messages to clients, over their control connections. Notifications of an older generation are ignored.
  void notify(const SessionDegraded& session);
  void announce_drain(std::chrono::milliseconds deadline);
  void announce_lights(const LightsNews& news);  // to the sessions of that scene

 private:
  void on_control_message(SessionId id, const Result<protocol::Message>& message);
  void on_control_lost(SessionId id, const std::string& why);
  void leave(SessionId id, const std::string& why);
  std::shared_ptr<ControlStream> drop(SessionId id, const std::string& why);

  const NetShared& shared_;
  const uint32_t net_thread_;
  asio::io_context& io_;
  OpenSessions& sessions_;
  SessionLinks& links_;
  Lobby& lobby_;
};

}  // namespace gnomon::daemon
