// What a client says of the datagrams that reached it, so that the server can measure the path: which arrived, and
// when. In the spirit of RFC 8888 (feedback of arrival times per packet). WIRE.md has the byte table.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace gnomon::protocol {

inline constexpr size_t kMaxReported = 512;  // datagrams in one Feedback
inline constexpr uint32_t kAgeUnitUs = 32;   // of Feedback::ages
inline constexpr uint16_t kOldest = 0xffff;  // this old or older

struct Feedback {
  uint64_t time_us = 0;     // by the client's clock, of any origin, when this was sent
  uint64_t first = 0;       // the lowest sequence number that this speaks of
  uint32_t recovered = 0;   // slices rebuilt from parity so far in the session; wraps
  uint32_t incomplete = 0;  // frames used with tiles missing so far; wraps
  uint16_t count = 0;       // of ages in use
  // Of sequence first + i: 0: has not arrived; else 1 + how long before time_us it came, in units of kAgeUnitUs.
  std::array<uint16_t, kMaxReported> ages{};
};

// Decoding is total and allocates nothing.
std::optional<Feedback> decode_feedback(std::span<const uint8_t> body);
void append_feedback(std::vector<uint8_t>& out, const Feedback& feedback);

}  // namespace gnomon::protocol
