// A control connection: messages in and out, over TLS. The only place where the daemon handles its bytes.
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
#include "daemon/security/client_certificates.h"
#include "protocol/messages.h"
#include "protocol/seal.h"

namespace gnomon::daemon {

// Used on one thread, that of the socket's io_context. Kept alive by its own pending operations.
class ControlStream : public std::enable_shared_from_this<ControlStream> {
 public:
  // `max_message_bytes`: a client that announces a longer message is cut off before the rest of it is read.
  // The TLS context may be destroyed before the stream.
  ControlStream(asio::ip::tcp::socket socket, asio::ssl::context& tls, size_t max_message_bytes);

  // Receives a message, or an error if the bytes are not a valid message; after an error it is not called again.
  using OnMessage = std::function<void(Result<protocol::Message>)>;
  // Called once if the connection ends by itself, not after finish() or close(). `fault` says why the TLS handshake
  // failed, and is handshake_abandoned if the connection ended otherwise; `why` is for the log.
  using OnEnd = std::function<void(Fault fault, const std::string& why)>;
  void listen(OnMessage on_message, OnEnd on_end);  // replaces earlier callbacks
  void start();                                     // the TLS handshake, then messages

  // A client that does not read what it is sent is cut off when more than kMaxUnsentBytes are waiting.
  void send(const protocol::Message& message);

  // Returns false, and sends nothing, if kMaxUnsentData bytes of messages are waiting already or the stream is closed.
  bool send_data(const protocol::Data& data);

  // Sends what is waiting, then waits for the client to close the connection, so that it can read everything. The
  // caller decides for how long, and then calls close().
  void finish();
  void close();
  bool is_open() const { return stream_.lowest_layer().is_open(); }

  // The following are exported from the TLS session. Precondition: a message has been received.

  ClientCertificate certificate();  // without names if the client showed none

  // The first secrets of the session's data channel.
  Result<protocol::SealSecrets> seal_secrets(SessionId session, protocol::CipherId cipher);

  // On the connection that opens the session: the secret that its client has to know in order to resume it.
  Result<protocol::Secret> resumption_secret(SessionId session);
  // On another connection: what a client that knows `secret` sends as the proof.
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
  std::deque<std::vector<uint8_t>> outgoing_;  // the front element is being written
  size_t unsent_bytes_ = 0;
  bool finishing_ = false;   // nothing more is delivered or queued
  bool peer_ended_ = false;  // the client has closed at least its sending side
  OnMessage on_message_;
  OnEnd on_end_;
};

}  // namespace gnomon::daemon
