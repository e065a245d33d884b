// The sessions of a net thread whose clients are browsers that reach us by WebTransport: their datagrams carry what Data
// messages carry. A session is opened over a WebSocket, is told a ticket there, and shows it on a connection of QUIC.
#pragma once

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>

#include "daemon/net/data_socket.h"
#include "daemon/net/net_shared.h"
#include "daemon/net/open_sessions.h"
#include "daemon/quic/endpoint.h"

namespace gnomon::daemon {

// Belongs to the net thread. Outlived by everything it refers to.
class WebTransport {
 public:
  WebTransport(const NetShared& shared, OpenSessions& sessions, asio::io_context& io)
      : shared_(shared), sessions_(sessions), timer_(io) {}

  // No effect where the configuration does not ask for WebTransport.
  Result<void> open(DataSocket& socket);

  struct Listener {
    std::function<void(Session&, const protocol::Data&)> data;
    std::function<void(Session&)> serve;  // there is room, or something to send again, or another way to send it
  };
  void listen(Listener listener) { listener_ = std::move(listener); }

  // A UDP payload that may be QUIC's. False if it is none of ours.
  bool receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from);

  // Tells the session's client the way to us, if it has the feature and is a browser.
  void offer(const Session& session);
  // Sends what the session's link releases now, as far as the path takes it. Returns false if it takes no more: the
  // listener is called once it does. Precondition: the session's way is WebTransport.
  bool send(Session& session, TimePoint now);
  void drop(SessionId id);  // the session is over

  // Once a second: another certificate where it is time for one, which clients are told.
  void review(TimePoint now);
  void close();

 private:
  struct Link {
    std::string ticket;                            // unused; empty if none was offered
    std::optional<quic::ConnectionId> connection;  // on which it is served
    uint64_t unused = 0;  // a sequence number that was taken for a datagram that found no room
  };

  Result<Identity> next_identity(TimePoint now);
  void handle_events(TimePoint now);
  void admit(quic::ConnectionId id, const quic::SessionAsked& asked, TimePoint now);
  std::optional<SessionId> owner_of(const quic::SessionAsked& asked) const;
  void on_datagram(quic::ConnectionId id, std::span<const uint8_t> bytes);
  void on_outcome(quic::ConnectionId id, const quic::Outcome& outcome, TimePoint now);
  void on_closed(quic::ConnectionId id);
  Session* session_of(quic::ConnectionId id) const;
  void flush(TimePoint now);
  void arm_timer();

  const NetShared& shared_;
  OpenSessions& sessions_;
  asio::steady_timer timer_;
  TimePoint armed_ = TimePoint::max();
  Listener listener_;
  DataSocket* socket_ = nullptr;
  std::unique_ptr<quic::Endpoint> endpoint_;  // nullptr: no WebTransport
  std::shared_ptr<const void> tls_;           // of which the certificate is
  std::vector<protocol::Bytes32> hashes_;     // of a certificate of our own
  TimePoint renew_at_ = TimePoint::max();
  std::unordered_map<SessionId, Link> links_;
  std::unordered_map<quic::ConnectionId, SessionId> owners_;
  bool handling_ = false;  // events: what they lead to is not handled within
};

}  // namespace gnomon::daemon
