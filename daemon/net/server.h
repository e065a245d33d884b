// The network side as a whole: one acceptor, and the net threads that it hands connections to in turn.
#pragma once

#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include <memory>
#include <vector>

#include "daemon/net/connection_rate.h"
#include "daemon/net/net_thread.h"

namespace gnomon::daemon {

class Server {
 public:
  static Result<std::unique_ptr<Server>> open(const NetShared& shared);
  ~Server();

  uint16_t control_port() const { return control_port_; }
  std::vector<uint16_t> data_ports() const;
  void run();

  // Any thread.
  void deliver(EncodedFrame frame) {
    NetThread& thread = *threads_[frame.meta.route.net_thread];
    thread.deliver(std::move(frame));
  }
  void notify(const SessionDegraded& session);
  bool kick(SessionId id, const std::string& why);  // false: there is no such session. Blocking
  void announce_drain(std::chrono::milliseconds deadline);
  void announce_lights(const LightsUpdate& update);
  void close_closed_tenants();
  std::vector<SessionStatus> sessions() const;

  void stop();  // everybody is told, everything is closed
  // The same without a word: for whoever comes after us to resume the sessions.
  void leave();

 private:
  explicit Server(const NetShared& shared);
  void accept();
  void stop(bool for_good);

  Metrics& metrics_;
  ConnectionRate rate_;  // the first net thread's, as what follows it
  std::vector<std::unique_ptr<NetThread>> threads_;
  std::unique_ptr<asio::ip::tcp::acceptor> acceptor_;  // the first net thread's
  std::unique_ptr<asio::steady_timer> retry_;
  uint16_t control_port_ = 0;
  size_t next_ = 0;  // who gets the next connection
};

}  // namespace gnomon::daemon
