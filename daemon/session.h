// One client's use of one scene: what its datagrams mean, where its frames go, what it has cost lately.
#pragma once

#include <asio/ip/udp.hpp>

#include <memory>
#include <optional>
#include <string>

#include "daemon/faults.h"
#include "daemon/frame.h"
#include "daemon/handshake.h"
#include "daemon/seats.h"
#include "protocol/seal.h"

namespace gnomon::daemon {

// What a datagram amounts to: a view, or what is wrong with it, or neither (a repeated frame id is no news).
struct Received {
  std::optional<ViewRequest> view;
  std::optional<Fault> fault;
};

// The net thread's that owns it.
class Session {
 public:
  Session(SessionId id, std::unique_ptr<protocol::Seal> seal, Accepted accepted, Seat seat, TimePoint now);

  SessionId id() const { return id_; }
  const Accepted& accepted() const { return accepted_; }
  protocol::Seal& seal() { return *seal_; }

  // Where the last valid datagram came from; nothing is sent anywhere else.
  const std::optional<asio::ip::udp::endpoint>& address() const { return address_; }

  Received receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from, TimePoint now);

  TimePoint last_heard() const { return last_heard_; }

  void frame_sent(const FrameMeta& meta, TimePoint sent);

  // Totals of the session, means since the last call (those of an interval without frames are 0).
  protocol::Stats take_stats();

 private:
  struct Sums {
    uint32_t frames = 0;
    Nanoseconds queue{}, gpu{}, total{};
  };

  SessionId id_;
  Accepted accepted_;
  Seat seat_;
  std::unique_ptr<protocol::Seal> seal_;
  std::optional<asio::ip::udp::endpoint> address_;
  std::optional<FrameId> newest_;
  TimePoint last_heard_;
  uint64_t frames_ = 0;
  uint64_t coalesced_ = 0;
  Sums recent_;
};

}  // namespace gnomon::daemon
