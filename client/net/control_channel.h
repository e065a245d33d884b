// The control connection: protocol messages over TLS.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "client/net/address.h"
#include "client/net/loop.h"
#include "client/net/trust.h"
#include "common/result.h"
#include "protocol/messages.h"
#include "protocol/seal.h"

namespace gnomon::client {

// The loop's thread. Call backs may destroy the channel.
class ControlChannel {
 public:
  struct Events {
    std::function<void()> connected = {};  // the server is the right one
    std::function<void(protocol::Message)> message = {};
    std::function<void(const Error&)> failed = {};  // once, and nothing after it; never after close()
  };

  // Starts to look up and connect.
  ControlChannel(Loop& loop, const Address& server, const Trust& trust, Events events);
  ~ControlChannel();  // drops the connection

  void send(const protocol::Message& message);

  // Says Bye, as far as the connection takes it without waiting, and closes.
  void close(const std::string& reason);

  // The server's numeric address; valid once connected.
  std::string server_ip() const;

  // Of the data channel, from this connection's TLS session; once connected.
  Result<protocol::SealSecrets> seal_secrets(SessionId session, protocol::CipherId cipher) const;

  // Of a session that this connection opened; and, on another one, what proves that it is known. Once connected.
  Result<protocol::Secret> resumption_secret(SessionId session) const;
  Result<protocol::Secret> resumption_proof(SessionId session, const protocol::Secret& secret) const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace gnomon::client
