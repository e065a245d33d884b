// A session with a Gnomon daemon: Hello and Welcome (or Refused) over the control connection, then datagrams.
//
// Belongs to one Loop and its thread. Most programs use client/stream/visibility_stream.h, which assembles frames on
// top of this.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "client/net/address.h"
#include "client/net/control_channel.h"
#include "client/net/data_channel.h"
#include "client/net/fleet_route.h"
#include "client/net/loop.h"
#include "client/net/path_watch.h"
#include "common/result.h"
#include "protocol/messages.h"

namespace gnomon::client {

struct ConnectOptions {
  Address server;
  Trust trust = {};
  Transport transport = Transport::automatic;
  protocol::Hello hello;  // what to ask for; without ciphers, this processor's fastest comes first
  // Until the Welcome or, as the server may load the scene first, another word of what is waited for.
  Nanoseconds timeout = std::chrono::seconds(15);
};

// One line for a person: code, text and what would fit.
std::string describe(const protocol::Refused& refused);

// Called while the loop runs. They may close the connection, but must not destroy it.
struct ConnectionEvents {
  std::function<void()> opened = {};  // Welcome has arrived
  // The control connection was lost and has been replaced: the session continues with what welcome() now says. Frames
  // asked for before are not answered any more.
  std::function<void()> resumed = {};
  std::function<void(const protocol::Message&)> message = {};  // any later one; Waiting also before opened()
  std::function<void(const protocol::Opened&, TimePoint arrived)> datagram = {};  // borrowed for the call
  std::function<void(const Error&)> closed = {};  // by the server or the network, not by close()
};

class Connection {
 public:
  enum class State { connecting, open, closed };

  // Starts to connect. Any of `events` may be empty. `loop` outlives the connection.
  Connection(Loop& loop, ConnectOptions options, ConnectionEvents events);
  ~Connection();  // closes

  State state() const { return state_; }  // open also while the session is being resumed
  // Serves the loop until the session is open. Error: why it is not (one line).
  Result<void> wait_open();
  // Why the server or the network closed, or the server refused; nullopt if none did.
  const std::optional<Error>& failure() const { return failure_; }
  // Also set, with the code kept_out, where the server ended the session and keeps this client out for a time.
  const std::optional<protocol::Refused>& refusal() const { return refusal_; }

  const protocol::Welcome& welcome() const { return welcome_; }  // once open
  DataCounters data_counters() const;

  // True while Resume has been sent on a new control connection and the server has not answered it.
  bool resuming() const { return asked_to_resume_; }

  // True if datagrams do not pass or are not wanted: what they would carry goes over the control connection.
  bool by_control() const { return !path_.by_udp(); }

  // Sends `body` as a sealed datagram or, if by_control(), over the control connection. No effect unless open. Loss is
  // silent.
  void send(protocol::DatagramKind kind, std::span<const uint8_t> body);

  // Sends Bye and closes. Idempotent.
  void close(const std::string& reason);

 private:
  ControlChannel::Events control_events(std::function<void()> connected);
  void on_message(protocol::Message message);
  void on_welcome(protocol::Welcome welcome);
  void on_control_lost(const Error& error);
  void lose_control(const Error& error);
  void connect(const Address& where);
  void connect_again();
  void ask_to_resume();
  void on_resumed(protocol::Welcome welcome);
  void on_data(const protocol::Data& data);
  void on_datagram(const protocol::Opened& datagram, TimePoint arrived);
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
  FleetRoute route_;
  uint64_t sent_by_control_ = 0;
  DataCounters by_control_;
  Timer handshake_timer_;
  Timer path_timer_;
  protocol::Secret resumption_{};
  std::optional<Error> lost_;  // why the control connection that is being replaced was lost
  TimePoint resume_until_{}, resumed_{};
  bool asked_to_resume_ = false;
  TimePoint control_heard_{};
  Timer resume_timer_;
  std::unique_ptr<DataChannel> data_;
  std::unique_ptr<ControlChannel> control_;
};

}  // namespace gnomon::client
