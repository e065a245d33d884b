// How the sessions of a net thread begin, are controlled, continue without a control connection, and end.
#pragma once

#include <asio/io_context.hpp>

#include <chrono>
#include <memory>
#include <string>
#include <unordered_set>

#include "daemon/net/pending_connections.h"
#include "daemon/net/session_links.h"

namespace gnomon::daemon {

// Belongs to the net thread. Outlived by everything it refers to.
class SessionControl {
 public:
  // `net_thread`: the index of this net thread.
  SessionControl(const NetShared& shared, uint32_t net_thread, asio::io_context& io, OpenSessions& sessions,
                 SessionLinks& links, PendingConnections& pending);

  // Starts to serve the session, controlled by `stream`. Precondition: `stream` is no longer pending.
  const Session& open(SessionParts parts, const std::shared_ptr<ControlStream>& stream);

  // Tells its client, once it has its Welcome, of a way beside the control connection.
  void offer_web_transport(const Session& session) { links_.web_transport().offer(session); }

  // Ends the session for good and sends its client a Bye with the reason and the time for which it is not let in again
  // (0: it may come back). No effect if there is no such session.
  void close(SessionId id, const std::string& why, std::chrono::milliseconds stay_out = {});
  // Closes the session for an operator, and keeps its client out.
  void kick(SessionId id, const Kick& kick);
  // Closes the sessions whose client has been silent for too long, or has not come back to resume them.
  void close_silent(TimePoint now);
  // Closes the sessions that may not go on: their tenant is no longer served, or their credential was revoked, has
  // expired or is too old.
  void close_unwelcome();

  // Ends every session: closes it if `for_good` or if it cannot be resumed, else leaves it to be resumed elsewhere.
  void end_all(bool for_good);

  // Messages to clients, over their control connections. Notifications that carry an older generation are ignored.
  void notify(const SessionDegraded& session);
  void announce_drain(std::chrono::milliseconds deadline);
  // To those with kFeatureFleet: whether they are to move to another node of their fleet.
  void ask_to_move(bool move);
  void ask_to_move(SessionId id, bool move);
  void announce_lights(const LightsUpdate& update);  // to the sessions of its scene

 private:
  void on_control_message(SessionId id, const Result<protocol::Message>& message);
  void on_control_lost(SessionId id, const std::string& why);
  void leave(SessionId id, const std::string& why);
  void tell_to_go(SessionId id, ControlStream& stream, protocol::Draining message);
  std::shared_ptr<ControlStream> drop(SessionId id, const std::string& why);

  const NetShared& shared_;
  const uint32_t net_thread_;
  asio::io_context& io_;
  OpenSessions& sessions_;
  SessionLinks& links_;
  PendingConnections& pending_;
  std::unordered_set<SessionId> moving_;  // whose clients were asked to move
};

}  // namespace gnomon::daemon
