// The traffic of a net thread's sessions: views in, as far as the session's link has room for their frames, and frames
// out at the link's pace. Owns the UDP socket and the time at which each link has to be served again.
#pragma once

#include <asio/io_context.hpp>
#include <asio/steady_timer.hpp>

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "daemon/net/data_socket.h"
#include "daemon/net/frame_sender.h"
#include "daemon/net/net_shared.h"
#include "daemon/net/open_sessions.h"
#include "daemon/net/timer_queue.h"
#include "daemon/net/web_transport.h"

namespace gnomon::daemon {

// Belongs to the net thread. Outlived by everything it refers to.
class SessionLinks {
 public:
  SessionLinks(const NetShared& shared, OpenSessions& sessions, asio::io_context& io);

  // Error if the socket cannot be opened there.
  Result<void> open(const asio::ip::udp::endpoint& local);
  uint16_t data_port() const { return data_->port(); }
  void start();  // datagrams are received from now on
  // `ends` is called, with a reason, for a session whose client has said what cannot be true. It may close the session.
  using OnEnd = std::function<void(SessionId, const std::string& why)>;
  void when_ended(OnEnd ends) { ends_ = std::move(ends); }
  void close();  // no further datagram is received or sent

  // Receives what a client has sent over its control connection, or by WebTransport, in place of a datagram.
  void receive(Session& session, const protocol::Data& data, Way way = Way::control);
  // Sends a frame of one of the sessions. Drops and counts it if the session has ended or cannot be reached, or if its
  // client has not been notified of the frame's size and cannot be, as the control connection is lost.
  void send(EncodedFrame& frame);
  // The session's control connection has room again for what waits in its link.
  void on_room(SessionId id);
  // The session is not served until its client can be reached again.
  void pause(SessionId id) { timers_.remove(id); }
  // The session is over.
  void forget(SessionId id) {
    pause(id);
    web_transport_.drop(id);
  }
  WebTransport& web_transport() { return web_transport_; }

 private:
  void receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from);
  void handle_fault(const Session& session, const DatagramOutcome& received);
  void request(const Session& session, const ViewRequest& view);
  void serve(Session& session);
  bool send_what_waits(Session& session, TimePoint now);
  void finish(Session& session, const FramesUnderWay::Ended& ended, TimePoint now);
  void wake(SessionId id, TimePoint when);  // serve() is called then; never for TimePoint::max()
  void arm_timer();
  void serve_due();

  const NetShared& shared_;
  OpenSessions& sessions_;
  asio::io_context& io_;
  std::unique_ptr<DataSocket> data_;
  FrameSender sender_;
  WebTransport web_transport_{shared_, sessions_, io_};
  OnEnd ends_;
  TimerQueue timers_;
  asio::steady_timer timer_{io_};
  TimePoint armed_ = TimePoint::max();  // what timer_ waits for
};

}  // namespace gnomon::daemon
