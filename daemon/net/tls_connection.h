// The bytes of a control connection, over TLS: what arrives is handed on, what is sent waits in a queue. Knows no message.
#pragma once

#include <array>
#include <asio/ip/tcp.hpp>
#include <asio/ssl/stream.hpp>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/metrics/faults.h"
#include "daemon/web/web_response.h"

namespace gnomon::daemon {

// Used on one thread, that of the socket's io_context. Kept alive by its own pending operations.
class TlsConnection : public std::enable_shared_from_this<TlsConnection> {
 public:
  // `client`: who is at the other end, or at that of a proxy. The TLS context may be destroyed before the connection.
  TlsConnection(asio::ip::tcp::socket socket, const asio::ip::address& client, asio::ssl::context& tls);
  virtual ~TlsConnection() = default;

  void start();  // the TLS handshake, then on_open() and on_bytes()
  bool is_open() const { return stream_.lowest_layer().is_open(); }
  const asio::ip::address& peer() const { return peer_; }
  const asio::ip::tcp::endpoint& reached() const { return reached_; }  // our own address

  // No effect if the connection is closed or finishing. What is shared is not copied, and not counted as unsent.
  void send_bytes(std::vector<uint8_t> bytes);
  void send_bytes(web::SharedBytes bytes);
  bool has_sent_all() const { return outgoing_.empty(); }
  void end_later(const std::string& why);  // ends the connection when the caller has returned; `why` is for the log

 protected:
  virtual void on_open() = 0;
  virtual void on_bytes(std::span<const uint8_t> bytes) = 0;  // not after finish_sending()
  virtual void on_sent(size_t bytes) = 0;                     // the kernel has taken them
  // Once, if the connection ends by itself and not by close(). `fault` says why the TLS handshake failed, which
  // a PROXY header in its place is one reason for, and is handshake_abandoned if the connection ended otherwise; `why` is for the log.
  virtual void on_ended(Fault fault, const std::string& why) = 0;

  size_t unsent_bytes() const { return unsent_bytes_; }
  bool is_finishing() const { return finishing_; }
  // Sends what is waiting, then waits for the client to close the connection, so that it can read everything.
  void finish_sending();
  void close_socket();
  ssl_st* tls() { return stream_.native_handle(); }

 private:
  struct Outgoing {
    std::vector<uint8_t> own;
    web::SharedBytes shared = nullptr;  // in the place of `own`
    size_t sent = 0;

    std::span<const uint8_t> rest() const { return std::span(shared ? *shared : own).subspan(sent); }
  };

  void queue(Outgoing outgoing);
  void read();
  void write();
  void written(size_t bytes);
  void all_written();
  void end(Fault fault, const std::string& why);

  asio::ssl::stream<asio::ip::tcp::socket> stream_;
  asio::ip::address peer_;
  asio::ip::tcp::endpoint reached_;
  std::array<uint8_t, 4096> incoming_;
  std::deque<Outgoing> outgoing_;  // the front element is being written
  size_t unsent_bytes_ = 0;        // but for what is shared
  bool finishing_ = false;         // nothing more is delivered or queued
  bool peer_ended_ = false;        // the client has closed at least its sending side
  bool ended_ = false;
};

}  // namespace gnomon::daemon
