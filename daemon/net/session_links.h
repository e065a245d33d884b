// What goes through the links of a net thread's sessions: views in, as far as a link has room for their frames, and
// frames out at its pace. Owns the UDP socket and the time at which each link has to be served again.
#pragma once

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>

#include <memory>

#include "daemon/net/data_socket.h"
#include "daemon/net/frame_sender.h"
#include "daemon/net/net_shared.h"
#include "daemon/net/open_sessions.h"
#include "daemon/net/wake_list.h"

namespace gnomon::daemon {

// The net thread's. Outlived by what it refers to.
class SessionLinks {
 public:
  SessionLinks(const NetShared& shared, OpenSessions& sessions, asio::io_context& io);

  // Error if the socket cannot be opened there.
  Result<void> open(const asio::ip::udp::endpoint& local);
  uint16_t data_port() const { return data_->port(); }
  void start();  // datagrams are received from now on
  void close();  // no further datagram is received or sent

  // What a client has sent over its control connection in the place of a datagram.
  void receive(Session& session, const protocol::Data& data);
  // A frame of one of the sessions; dropped and counted if its session is gone or cannot be reached.
  void send(EncodedFrame& frame);
  // The session is not served until its client is heard again.
  void pause(SessionId id) { wakes_.remove(id); }

 private:
  void receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from);
  void request(const Session& session, const ViewRequest& view);
  void serve(Session& session);
  void finish(Session& session, const Session::Ended& ended, TimePoint now);
  void arm_timer();
  void serve_due();

  const NetShared& shared_;
  OpenSessions& sessions_;
  asio::io_context& io_;
  std::unique_ptr<DataSocket> data_;
  FrameSender sender_;
  WakeList wakes_;
  asio::steady_timer timer_{io_};
  TimePoint armed_ = TimePoint::max();  // what timer_ waits for
};

}  // namespace gnomon::daemon
