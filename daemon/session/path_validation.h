// To which address a session's datagrams go: to none that has not shown that it receives them. After RFC 9000, 8 and 9.
//
//   received() -> challenge_due(), sent to the candidate -> answered(): the candidate becomes the current address
//
// Without it the owner of a session could aim its stream at anybody, by datagrams with a forged source. No socket and
// no clock; belongs to its session, on the net thread.
#pragma once

#include <asio/ip/udp.hpp>

#include <array>
#include <functional>
#include <optional>

#include "common/clock.h"
#include "protocol/datagram.h"

namespace gnomon::daemon {

class PathValidation {
 public:
  using Endpoint = asio::ip::udp::endpoint;

  // Of the bytes that an address has sent us, so many times as many are sent to it before it is validated (RFC 9000,
  // 8.1).
  static constexpr size_t kMostAmplification = 3;
  static constexpr size_t kChallengeBytes =
      protocol::kHeaderBytes + protocol::kPathTokenBytes + protocol::kTagBytes;
  // Challenges to an address, each after twice the time of the one before, as they or their answers may be lost.
  static constexpr size_t kTries = 4;
  static constexpr Nanoseconds kFirstWait = std::chrono::milliseconds(200);
  static constexpr Nanoseconds kPatience = std::chrono::seconds(3);  // then the address is given up

  // `validates`: false for a client without the feature, whose address is believed. `random`: unpredictable numbers.
  PathValidation(bool validates, std::function<uint64_t()> random)
      : validates_(validates), random_(std::move(random)) {}

  // Where datagrams go; nullopt if no address was validated yet.
  const std::optional<Endpoint>& current() const { return current_; }

  // An authentic datagram of `bytes` came from `from`. `newest`: no higher sequence number has come before, as one that
  // was held back does not show where the client is now. `streams`: it carries a view or Feedback; what only tries a
  // path (a Ping) does not move the stream, but may be the first sign of where the client is.
  void received(const Endpoint& from, size_t bytes, bool newest, bool streams, TimePoint now);

  // Bytes of datagrams to `to` other than challenges and the stream.
  void sent(const Endpoint& to, size_t bytes);

  struct Challenge {
    Endpoint to;
    uint64_t token = 0;
  };
  // The challenge that is to be sent now, as one datagram of kChallengeBytes; nullopt if none is.
  std::optional<Challenge> challenge_due(TimePoint now);

  struct Move {
    bool other_host = false;  // not only another port of the address that was current before
    bool streams = false;     // the client has sent views or Feedback from there
  };
  // The client has sent a token back, from any address: it has received the challenge. nullopt if it is of none that
  // waits for an answer.
  std::optional<Move> answered(uint64_t token);

  // True, once each, if an address has been given up. The current one stays.
  bool take_failure(TimePoint now);

  // When challenge_due() or take_failure() should be called again; TimePoint::max() if no address is being validated.
  TimePoint wake_at() const;
  bool is_pending() const { return candidate_.has_value(); }

 private:
  // The address that is being validated.
  struct Candidate {
    Endpoint address;
    TimePoint began{};
    size_t received = 0, sent = 0;  // bytes
    bool streams = false;
    size_t tries = 0;
    TimePoint next{};
    std::array<uint64_t, kTries> tokens{};
  };

  bool may_challenge() const;

  bool validates_;
  std::function<uint64_t()> random_;
  std::optional<Endpoint> current_;
  std::optional<Candidate> candidate_;
};

}  // namespace gnomon::daemon
