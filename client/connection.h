// A session with a Gnomon daemon: Hello and Welcome (or Refused) over the control connection, then datagrams.
//
// Belongs to one Loop and its thread. client/visibility_stream.h is what most programs want: it puts frames
// together on top of this.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "client/address.h"
#include "client/control_channel.h"
#include "client/data_channel.h"
#include "client/loop.h"
#include "client/path_watch.h"
#include "common/result.h"
#include "protocol/messages.h"

namespace gnomon::client {

struct ConnectOptions {
  Address server;
  Trust trust = {};
  Transport transport = Transport::automatic;
  protocol::Hello hello;  // what to ask for; ciphers left empty: by what this processor does best
  Nanoseconds timeout = std::chrono::seconds(15);  // until the Welcome; the server may load the scene first
};

// One line for a person: code, text and what would fit.
std::string describe(const protocol::Refused& refused);

// Call backs come while the loop runs; they may close the connection, but not destroy it.
struct ConnectionEvents {
  std::function<void()> opened = {};                                              // Welcome has come
  std::function<void(const protocol::Message&)> message = {};                     // any message after it
  std::function<void(const protocol::Opened&, TimePoint arrived)> datagram = {};  // borrowed for the call
  std::function<void(const Error&)> closed = {};  // by the server or the network; not by close()
};

class Connection {
 public:
  enum class State { connecting, open, closed };

  // Starts to connect. Any of `events` may be empty.
  Connection(Loop& loop, ConnectOptions options, ConnectionEvents events);
  ~Connection();  // closes

  State state() const { return state_; }
  // Serves the loop until the session is open. Error: why it is not (one line).
  Result<void> wait_open();
  // Why the server or the network closed, or the server refused.
  const std::optional<Error>& failure() const { return failure_; }
  const std::optional<protocol::Refused>& refusal() const { return refusal_; }

  const protocol::Welcome& welcome() const { return welcome_; }  // once open
  DataCounters data_counters() const;

  // True: datagrams do not pass, or are not wanted; what they would carry goes over the control connection.
  bool by_control() const { return !path_.by_udp(); }

  // Seals and sends a datagram, or what it would carry; nothing happens unless open. Loss is silent.
  void send(protocol::DatagramKind kind, std::span<const uint8_t> body);

  // Says Bye and closes.
  void close(const std::string& reason);

 private:
  void on_message(protocol::Message message);
  void on_welcome(protocol::Welcome welcome);
  void on_data(const protocol::Data& data);
  void watch_path();
  void fail(Error error);

  Loop& loop_;
  ConnectOptions options_;
  ConnectionEvents events_;
  State state_ = State::connecting;
  std::optional<Error> failure_;
  std::optional<protocol::Refused> refusal_;
  protocol::Welcome welcome_;
  PathWatch path_;
  uint64_t sent_by_control_ = 0;
  DataCounters by_control_;
  Timer handshake_timer_;
  Timer path_timer_;
  std::unique_ptr<DataChannel> data_;
  ControlChannel control_;
};

}  // namespace gnomon::client
