// The network side of the daemon: one acceptor, and the net threads that it hands connections to in turn.
#pragma once

#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>

#include <memory>
#include <vector>

#include "common/token_buckets.h"
#include "daemon/net/door_port.h"
#include "daemon/net/net_thread.h"
#include "daemon/net/proxy_greeting.h"
#include "daemon/session/client_network.h"

namespace gnomon::daemon {

class Server {
 public:
  // Opens the ports. The error names the port and the reason.
  static Result<std::unique_ptr<Server>> open(const NetShared& shared);
  ~Server();  // stop()

  uint16_t control_port() const { return control_port_; }
  std::vector<uint16_t> data_ports() const;                         // of each net thread
  uint16_t door_port() const { return door_ ? door_->port() : 0; }  // 0: there is none
  void run();                                                       // starts the net threads

  // Any thread.
  void deliver(EncodedFrame frame) {
    NetThread& thread = *threads_[frame.meta.route.net_thread];
    thread.deliver(std::move(frame));
  }
  void notify(const SessionDegraded& session);
  bool kick(SessionId id, const Kick& kick);  // false if there is no such session. Blocks; not a net thread
  void announce_drain(std::chrono::milliseconds deadline);
  void ask_to_move(bool move);  // the clients of a fleet: to another node of it
  void announce_lights(const LightsUpdate& update);
  void close_unwelcome();
  std::vector<SessionStatus> sessions() const;

  // Both block until the net threads have ended. They are called on one thread, not a net thread.
  void stop();   // closes every session, with a Bye to its client
  void leave();  // leaves sessions that can be resumed to the next process, without a Bye; closes the others

 private:
  explicit Server(const NetShared& shared);
  void accept();
  void accept_later(asio::error_code error);
  void take(NetThread& owner, asio::ip::tcp::socket socket);
  void take_from_proxy(NetThread& owner, asio::ip::tcp::socket socket, const asio::ip::address& proxy);
  void hand_on(NetThread& owner, asio::ip::tcp::socket socket, const asio::ip::address& client);
  void stop(bool for_good);

  Metrics& metrics_;
  const ProxyAddresses proxies_;
  const Nanoseconds patience_;  // with a proxy, until its header is there
  // A TLS handshake costs a server more than a client. Used by the first net thread, as are the acceptor, the timer and
  // next_.
  TokenBuckets<ClientNetwork> connections_;
  std::vector<std::unique_ptr<NetThread>> threads_;
  std::unique_ptr<asio::ip::tcp::acceptor> acceptor_;
  std::unique_ptr<asio::steady_timer> retry_;
  std::unique_ptr<DoorPort> door_;  // nullptr: there is none; of the first net thread
  uint16_t control_port_ = 0;
  size_t next_ = 0;  // net thread that gets the next connection, modulo their number
};

}  // namespace gnomon::daemon
