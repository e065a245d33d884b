// A session with a Gnomon daemon: Hello and Welcome (or Refused) over the control connection, then datagrams.
//
// Belongs to one Loop and its thread. client/stream/visibility_stream.h is what most programs want: it puts frames
// together on top of this.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "client/net/address.h"
#include "client/net/control_channel.h"
#include "client/net/data_channel.h"
#include "client/net/loop.h"
#include "client/net/path_watch.h"
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
  std::function<void()> opened = {};  // Welcome has come
  // The control connection was lost and is replaced: the same session, as welcome() says now. What was asked for
  // before is not answered any more.
  std::function<void()> resumed = {};
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

  State state() const { return state_; }  // a session without control connection that tries to resume is open
  // Serves the loop until the session is open. Error: why it is not (one line).
  Result<void> wait_open();
  // Why the server or the network closed, or the server refused.
  const std::optional<Error>& failure() const { return failure_; }
  const std::optional<protocol::Refused>& refusal() const { return refusal_; }

  const protocol::Welcome& welcome() const { return welcome_; }  // once open
  DataCounters data_counters() const;

  // The other end has been asked to go on with the session, on another control connection, and has not said so yet.
  bool resuming() const { return asked_to_resume_; }

  // True: datagrams do not pass, or are not wanted; what they would carry goes over the control connection.
  bool by_control() const { return !path_.by_udp(); }

  // Seals and sends a datagram, or what it would carry; nothing happens unless open. Loss is silent.
  void send(protocol::DatagramKind kind, std::span<const uint8_t> body);

  // Says Bye and closes.
  void close(const std::string& reason);

 private:
  ControlChannel::Events control_events(std::function<void()> connected);
  void on_message(protocol::Message message);
  void on_welcome(protocol::Welcome welcome);
  bool fits(const protocol::Welcome& welcome);
  void on_control_lost(const Error& error);
  void lose_control(const Error& error);
  void connect_again();
  void ask_to_resume();
  void on_resumed(protocol::Welcome welcome);
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
  protocol::Secret resumption_{};
  std::optional<Error> lost_;  // why the control connection was lost that is to be replaced
  TimePoint resume_until_{}, resumed_{};
  bool asked_to_resume_ = false;
  TimePoint control_heard_{};
  Timer resume_timer_;
  std::unique_ptr<DataChannel> data_;
  std::unique_ptr<ControlChannel> control_;
};

}  // namespace gnomon::client
