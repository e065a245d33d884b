// A control connection as messages in and out, over TLS. The one place where the daemon touches its bytes.
#pragma once

#include <array>
#include <asio/ip/tcp.hpp>
#include <asio/ssl/stream.hpp>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/metrics/faults.h"
#include "protocol/messages.h"
#include "protocol/seal.h"

namespace gnomon::daemon {

// One thread: the one that runs the socket's io_context. Kept alive by its own pending operations.
class ControlStream : public std::enable_shared_from_this<ControlStream> {
 public:
  // `max_message_bytes`: a client that announces a longer message is cut off before any of it is stored.
  // The context may be gone before the stream.
  ControlStream(asio::ip::tcp::socket socket, asio::ssl::context& tls, size_t max_message_bytes);

  // A message, or why the bytes are none; after an error no further message comes.
  using OnMessage = std::function<void(Result<protocol::Message>)>;
  // The connection has ended by itself; not called after finish() or close(). `why` is for the log; the fault says what
  // a TLS handshake failed of, and is handshake_abandoned where it did not.
  using OnEnd = std::function<void(Fault fault, const std::string& why)>;
  void listen(OnMessage on_message, OnEnd on_end);  // to these from now on, in the place of earlier ones
  void start();                                     // the TLS handshake, then messages

  // A client that does not read what it is sent is cut off when kMaxUnsentBytes are waiting.
  void send(const protocol::Message& message);

  // False, and nothing is sent: kMaxUnsentData bytes of these are waiting already.
  bool send_data(const protocol::Data& data);

  // Sends what is waiting, then waits for the client to close, so that it can read to the end. How long is up to
  // the caller: close() cuts it short.
  void finish();
  void close();
  bool is_open() const { return stream_.lowest_layer().is_open(); }

  // The common name and the DNS names of the client's certificate, which one of our authorities has signed; empty: it
  // showed none. Once a message has come.
  std::vector<std::string> certificate_names() const;

  // Of the data channel, from this connection's TLS session; once a message has come.
  Result<protocol::SealSecrets> seal_secrets(SessionId session, protocol::CipherId cipher);

  // What the session's client will prove, here on the connection that opened it, that it knows; and what it has to send
  // to prove it on this one.
  Result<protocol::Secret> resumption_secret(SessionId session);
  Result<protocol::Secret> resumption_proof(SessionId session, const protocol::Secret& secret);

  const asio::ip::address& peer() const { return peer_; }

  static constexpr size_t kMaxUnsentBytes = 256 * 1024;
  static constexpr size_t kMaxUnsentData = 64 * 1024;

 private:
  void shake_hands();
  void queue(std::vector<uint8_t> bytes);
  void read();
  void deliver_messages();
  void write();
  void end(Fault fault, const std::string& why);
  void all_written();

  asio::ssl::stream<asio::ip::tcp::socket> stream_;
  asio::ip::address peer_;
  protocol::MessageReader reader_;
  std::array<uint8_t, 4096> incoming_;
  std::deque<std::vector<uint8_t>> outgoing_;  // the front one is being written
  size_t unsent_bytes_ = 0;
  bool finishing_ = false;  // nothing more is delivered or queued
  bool peer_ended_ = false;
  OnMessage on_message_;
  OnEnd on_end_;
};

}  // namespace gnomon::daemon
