// Finds the length of the longest datagram that the path carries. Pure.
//
// Packetization layer path MTU discovery for datagrams (RFC 8899): padded probes of growing size, each tried three
// times; the largest acknowledged size is used. The loss of a probe is no sign of congestion. If long datagrams no
// longer arrive (a black hole, because the path has changed), the base size is used again, and the search restarts
// kAfterBlackHole later.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "common/clock.h"
#include "protocol/types.h"

namespace gnomon::daemon {

class MtuDiscovery {
 public:
  // UDP payloads that common paths carry, in bytes: tunnels, Ethernet with IPv6 and IPv4, jumbo frames.
  static constexpr std::array<size_t, 7> kSizes{protocol::kMaxDatagramBytes, 1280, 1352, 1400, 1452, 1472,
                                                protocol::kMaxProbedBytes};
  static constexpr uint32_t kTries = 3;
  static constexpr Nanoseconds kSearchAgain = std::chrono::seconds(600);  // RFC 8899, 5.1.1: PMTU_RAISE_TIMER
  static constexpr Nanoseconds kAfterBlackHole = std::chrono::seconds(10);
  static constexpr Nanoseconds kBetweenProbes = std::chrono::milliseconds(50);
  static constexpr Nanoseconds kForgotten = std::chrono::seconds(10);  // a probe of which nothing more is heard
  static constexpr uint32_t kBlackHole = 10;                           // long datagrams lost in a row

  size_t bytes() const { return kSizes[level_]; }  // longest UDP payload to send

  // The size of the probe that is due; nullopt if none is.
  std::optional<size_t> probe_due(TimePoint now) const {
    const bool probing = probing_ && now < probe_sent_ + kForgotten;
    if (probing || now < next_probe_ || level_ + 1 >= kSizes.size()) return std::nullopt;
    return kSizes[level_ + 1];
  }

  void probe_sent(TimePoint now) {
    probing_ = true;
    probe_sent_ = now;
  }

  void probe_arrived(size_t size, TimePoint now) {
    probing_ = false;
    if (size > bytes() && level_ + 1 < kSizes.size()) ++level_;
    tries_ = 0;
    next_probe_ = now + kBetweenProbes;
  }

  void probe_lost(TimePoint now) {
    probing_ = false;
    next_probe_ = now + (++tries_ < kTries ? kBetweenProbes : kSearchAgain);
    if (tries_ >= kTries) tries_ = 0;
  }

  // Reports on datagrams other than probes.
  void arrived(size_t size) {
    if (size > kSizes[0]) lost_in_row_ = 0;
  }
  void lost(size_t size, TimePoint now) {
    if (level_ == 0 || size <= kSizes[0] || ++lost_in_row_ < kBlackHole) return;
    begin_anew(now);
  }

  // Call it when nothing has arrived for long: if every datagram is a long one, no later arrival reveals their loss.
  void silent(TimePoint now) {
    if (level_ > 0) begin_anew(now);
  }

 private:
  void begin_anew(TimePoint now) {
    level_ = 0;
    lost_in_row_ = tries_ = 0;
    next_probe_ = now + kAfterBlackHole;
  }

  size_t level_ = 0;
  uint32_t tries_ = 0;
  uint32_t lost_in_row_ = 0;
  bool probing_ = false;
  TimePoint next_probe_{}, probe_sent_{};
};

}  // namespace gnomon::daemon
