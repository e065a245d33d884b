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

// Used on the loop's thread only. Callbacks may destroy the channel.
class ControlChannel {
 public:
  struct Events {
    std::function<void()> connected = {};  // TLS is established, the server's certificate accepted
    std::function<void(protocol::Message)> message = {};
    std::function<void(const Error&)> failed = {};  // once, as the last callback; never after close()
  };

  // Starts to look up the server's name and to connect.
  // `scene`: what will be asked for, see server_name().
  ControlChannel(Loop& loop, const Address& server, const Trust& trust, const std::string& scene, Events events);
  ~ControlChannel();  // drops the connection

  void send(const protocol::Message& message);

  // Sends Bye, if the connection takes it without blocking, and closes. Idempotent.
  void close(const std::string& reason);

  // The server's numeric address; valid once connected.
  std::string server_ip() const;

  // The data channel's secrets, from this connection's TLS session. Precondition: connected.
  Result<protocol::SealSecrets> seal_secrets(SessionId session, protocol::CipherId cipher) const;

  // The resumption secret of a session that this connection opened; and the proof, valid on this connection, that the
  // secret of a session opened on another one is known. Precondition: connected.
  Result<protocol::Secret> resumption_secret(SessionId session) const;
  Result<protocol::Secret> resumption_proof(SessionId session, const protocol::Secret& secret) const;

 private:
  struct State;
  std::shared_ptr<State> state_;
};

}  // namespace gnomon::client
