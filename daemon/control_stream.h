// A control connection as messages in and out. The one place where the daemon touches its bytes: securing the
// connection is this file's business alone.
#pragma once

#include <array>
#include <asio/ip/tcp.hpp>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "protocol/messages.h"

namespace gnomon::daemon {

// One thread: the one that runs the socket's io_context. Kept alive by its own pending operations.
class ControlStream : public std::enable_shared_from_this<ControlStream> {
 public:
  // `max_message_bytes`: a client that announces a longer message is cut off before any of it is stored.
  ControlStream(asio::ip::tcp::socket socket, size_t max_message_bytes);

  // A message, or why the bytes are none; after an error no further message comes.
  using OnMessage = std::function<void(Result<protocol::Message>)>;
  // The connection has ended by itself; not called after finish() or close(). `why` is for the log.
  using OnEnd = std::function<void(const std::string& why)>;
  void listen(OnMessage on_message, OnEnd on_end);  // to these from now on, in the place of earlier ones
  void start();

  // A client that does not read what it is sent is cut off when kMaxUnsentBytes are waiting.
  void send(const protocol::Message& message);

  // Sends what is waiting, then waits for the client to close, so that it can read to the end. How long is up to
  // the caller: close() cuts it short.
  void finish();
  void close();
  bool is_open() const { return socket_.is_open(); }

  const asio::ip::address& peer() const { return peer_; }

  static constexpr size_t kMaxUnsentBytes = 256 * 1024;

 private:
  void read();
  void deliver_messages();
  void write();
  void end(const std::string& why);
  void all_written();

  asio::ip::tcp::socket socket_;
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
