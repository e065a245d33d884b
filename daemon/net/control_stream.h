// A control connection: messages in and out. A browser's begins as HTTP, and becomes one of messages when it goes on as a
// WebSocket.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "daemon/net/tls_connection.h"
#include "daemon/security/client_certificates.h"
#include "daemon/web/message_stream.h"
#include "protocol/messages.h"
#include "protocol/seal.h"

namespace gnomon::daemon {

// What speaks with a browser until its connection is one of messages.
class BrowserListener {
 public:
  virtual ~BrowserListener() = default;
  virtual void on_open() = 0;  // the TLS handshake is done, and the client is a browser
  virtual void on_bytes(std::span<const uint8_t> bytes) = 0;
  virtual void on_sent(size_t bytes) = 0;  // the kernel has taken them
  virtual bool is_idle() const = 0;        // nothing is under way between us and the browser
  virtual void on_end() = 0;               // the connection is closed or one of messages; nothing else is called
};

// Used on one thread, that of the socket's io_context. Kept alive by its own pending operations.
class ControlStream : public TlsConnection {
 public:
  // `max_message_bytes`: a client that announces a longer message is cut off before the rest of it is read.
  // The TLS context may be destroyed before the stream.
  ControlStream(asio::ip::tcp::socket socket, const asio::ip::address& client, asio::ssl::context& tls,
                size_t max_message_bytes);

  // Receives a message, or an error if the bytes are not a valid message; after an error it is not called again.
  using OnMessage = std::function<void(Result<protocol::Message>)>;
  // Called once if the connection ends by itself, not after finish() or close(). `fault` says why the TLS handshake
  // failed, and is handshake_abandoned if the connection ended otherwise; `why` is for the log.
  using OnEnd = std::function<void(Fault fault, const std::string& why)>;
  void listen(OnMessage on_message, OnEnd on_end);  // replaces earlier callbacks

  // Before start(): for a client that says in the TLS handshake (ALPN) that it is a browser.
  void listen_to_browser(std::shared_ptr<BrowserListener> listener) { browser_listener_ = std::move(listener); }
  bool is_browser() const { return browser_; }
  bool is_idle_browser() const { return browser_listener_ && browser_ && browser_listener_->is_idle(); }
  // The connection is one of messages from now on, in a WebSocket; `first` are bytes that have arrived already. The
  // listener is not called again.
  void become_websocket(std::span<const uint8_t> first, const std::string& origin);
  const std::string& origin() const { return origin_; }  // of the page that opened the WebSocket

  // A client that does not read what it is sent is cut off when more than kMaxUnsentBytes are waiting.
  void send(const protocol::Message& message);

  // Whether less than kMaxUnsentData bytes are waiting, so that a Data may be sent. If not, what when_room() was given
  // is called once there is room again.
  bool has_room();
  void when_room(std::function<void()> on_room) { on_room_ = std::move(on_room); }
  void send_data(const protocol::Data& data);  // no effect if the stream is closed

  // Sends what is waiting, then waits for the client to close the connection, so that it can read everything. The
  // caller decides for how long, and then calls close().
  void finish();
  void close();

  // The following are exported from the TLS session. Precondition: the handshake is done.

  ClientCertificate certificate();  // without names if the client showed none

  // The first secrets of the session's data channel.
  Result<protocol::SealSecrets> seal_secrets(SessionId session, protocol::CipherId cipher);

  // On the connection that opens the session: the secret that its client has to know in order to resume it.
  Result<protocol::Secret> resumption_secret(SessionId session);
  // On another connection: what a client that knows `secret` sends as the proof.
  Result<protocol::Secret> resumption_proof(SessionId session, const protocol::Secret& secret);

  static constexpr size_t kMaxUnsentBytes = 256 * 1024;
  static constexpr size_t kMaxUnsentData = 64 * 1024;

 private:
  void on_open() override;
  void on_bytes(std::span<const uint8_t> bytes) override;
  void on_sent(size_t bytes) override;
  void on_ended(Fault fault, const std::string& why) override;

  void deliver_messages();
  void cut_off_if_it_does_not_read();
  void forget_callbacks();
  void drop_listener();

  web::MessageStream messages_;
  std::shared_ptr<BrowserListener> browser_listener_;  // nullptr: the connection is one of messages
  bool browser_ = false;
  std::string origin_;
  bool wants_room_ = false;  // has_room() has said that there is none
  std::function<void()> on_room_;
  OnMessage on_message_;
  OnEnd on_end_;
};

}  // namespace gnomon::daemon
