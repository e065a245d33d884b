// The port that doors ask: a load balancer's health check and agent, and probes of a container's manager.
//
//   GET /readyz   200 while frames are answered, also while no new session is let in; else 503
//   agent         a line of HAProxy's agent protocol, see door_sign.h
//
// `/readyz` of the admin server fails as soon as nobody is let in. A door must not hear that: it would take the node for
// broken and cut the sessions that the node still serves.
#pragma once

#include <asio/awaitable.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include <memory>

#include "daemon/net/door_sign.h"
#include "daemon/net/net_shared.h"

namespace gnomon::daemon {

// Runs on the event loop that it is given, so that a door learns when that is stuck. Tells strangers how busy the node is
// and nothing else. Outlived by what it refers to.
class DoorPort {
 public:
  // nullptr if the configuration asks for no such port. The error names the port and the reason.
  static Result<std::unique_ptr<DoorPort>> open(const NetShared& shared, asio::io_context& io);

  void accept();
  uint16_t port() const { return port_; }

 private:
  DoorPort(const NetShared& shared, asio::io_context& io) : shared_(shared), io_(io), acceptor_(io), retry_(io) {}

  void answer_later(asio::ip::tcp::socket socket);
  asio::awaitable<void> answer(std::shared_ptr<asio::ip::tcp::socket> socket);
  std::string answer_to(const std::string& asked);

  const NetShared shared_;
  asio::io_context& io_;
  asio::ip::tcp::acceptor acceptor_;
  asio::steady_timer retry_;
  uint16_t port_ = 0;
  DoorSign sign_;
};

}  // namespace gnomon::daemon
