// The client's report of which of the server's datagrams arrived and when, from which the server measures the path.
// Modelled on RFC 8888 (RTCP feedback for congestion control), which reports arrival times per packet. WIRE.md has the
// byte table.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace gnomon::protocol {

inline constexpr size_t kMaxReported = 512;  // datagrams in one Feedback
inline constexpr uint32_t kAgeUnitUs = 32;   // unit of Feedback::ages
inline constexpr uint16_t kOldest = 0xffff;  // an age that is this or more

struct Feedback {
  uint64_t time_us = 0;     // by the client's clock, of any origin, when this was sent
  uint64_t first = 0;       // the lowest sequence number reported
  uint32_t recovered = 0;   // slices rebuilt from parity so far in the session; wraps
  uint32_t incomplete = 0;  // frames used with tiles missing so far; wraps
  uint16_t count = 0;       // entries of `ages` in use
  // ages[i] is of sequence number first + i: 0 if it has not arrived, else 1 + its age at time_us in kAgeUnitUs.
  std::array<uint16_t, kMaxReported> ages{};
};

// Total: any bytes give a Feedback or nullopt. Allocates nothing.
std::optional<Feedback> decode_feedback(std::span<const uint8_t> body);
void append_feedback(std::vector<uint8_t>& out, const Feedback& feedback);

}  // namespace gnomon::protocol
