// The sessions of one net thread, and the control connection of each that has one. Belongs to the net thread.
#pragma once

#include <memory>
#include <unordered_map>
#include <utility>

#include "daemon/net/control_stream.h"
#include "daemon/session/session_table.h"

namespace gnomon::daemon {

class OpenSessions {
 public:
  Session& add(std::unique_ptr<Session> session, std::shared_ptr<ControlStream> stream) {
    streams_.emplace(session->id(), std::move(stream));
    return table_.add(std::move(session));
  }

  // nullptr if there is no such session.
  Session* find(SessionId id) const { return table_.find(id); }

  // nullptr if the session has no control connection.
  ControlStream* stream_of(SessionId id) const {
    const auto found = streams_.find(id);
    return found == streams_.end() ? nullptr : found->second.get();
  }

  // Takes the session's control connection away; nullptr if it has none.
  std::shared_ptr<ControlStream> take_stream(SessionId id) {
    const auto found = streams_.find(id);
    if (found == streams_.end()) return nullptr;
    auto stream = std::move(found->second);
    streams_.erase(found);
    return stream;
  }

  // Precondition: take_stream() was called for the session.
  void remove(SessionId id) { table_.remove(id); }

  // Whether frames can be sent to the client now: over the control connection or to its UDP address.
  bool is_reachable(Session& session) const {
    if (session.way() == Way::web_transport) return true;  // while it is its way, there is a connection
    return session.way() == Way::control ? stream_of(session.id()) != nullptr
                                         : session.path().current().has_value();
  }

  Transport transport_of(Session& session) const {
    if (session.way() == Way::web_transport) return Transport::webtransport;
    const ControlStream* const stream = session.way() == Way::control ? stream_of(session.id()) : nullptr;
    if (!stream) return Transport::udp;
    return stream->is_browser() ? Transport::websocket : Transport::tcp;
  }

  const SessionTable& table() const { return table_; }
  const std::unordered_map<SessionId, std::shared_ptr<ControlStream>>& streams() const { return streams_; }

 private:
  SessionTable table_;
  std::unordered_map<SessionId, std::shared_ptr<ControlStream>> streams_;
};

}  // namespace gnomon::daemon
