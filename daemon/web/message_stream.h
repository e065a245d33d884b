// How control messages lie in the bytes of a connection: one after the other, or, for browsers, each in a binary message
// of a WebSocket. Pure: no socket, no clock.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "daemon/web/websocket.h"
#include "protocol/messages.h"

namespace gnomon::daemon::web {

// One thread.
class MessageStream {
 public:
  explicit MessageStream(size_t max_message_bytes) : max_(max_message_bytes), reader_(max_message_bytes) {}

  // From now on the bytes, either way, are those of a WebSocket. Precondition: nothing was fed before.
  void become_websocket() { frames_.emplace(max_); }
  bool is_websocket() const { return frames_.has_value(); }

  void feed(std::span<const uint8_t> bytes);
  // nullopt if no further message is complete. An error is final: the connection is to be closed.
  Result<std::optional<protocol::Message>> next();

  // Bytes that answer what was read: pongs, and the client's close frame.
  std::vector<uint8_t> take_replies() { return std::exchange(replies_, {}); }
  // Whether the client has closed the WebSocket. Nothing further is read.
  bool is_closed() const { return closed_; }

  // An encoded message as it is sent.
  std::vector<uint8_t> framed(std::vector<uint8_t> message) const;
  // What is sent last; empty if nothing is to be said, or has been said.
  std::vector<uint8_t> farewell() const;

 private:
  Error fail(const Violation& violation);

  size_t max_;
  protocol::MessageReader reader_;
  std::optional<FrameReader> frames_;  // nullopt: messages follow each other
  std::vector<uint8_t> replies_;
  bool closed_ = false;
  CloseCode farewell_ = CloseCode::normal;  // another one after a violation
  std::optional<Error> failed_;
};

}  // namespace gnomon::daemon::web
