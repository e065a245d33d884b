// Forward error correction of a frame: its slices in groups, and to each group parity shards from which as many lost
// slices can be rebuilt. A Cauchy Reed-Solomon code over GF(2^8), by Intel ISA-L (Bloemer et al. 1995). WIRE.md has
// the format.
//
// Slice s is in group s % groups, so that a burst of losses hits many groups a little. A slice's shard is its body's
// length (u16), the body, and zeros up to the longest of its group.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "common/ids.h"

namespace gnomon::protocol {

inline constexpr size_t kMaxGroupSlices = 128;
inline constexpr size_t kMaxGroupParity = 64;
inline constexpr size_t kParityHeaderBytes = 12;
inline constexpr size_t kShardLengthBytes = 2;
// A slice's body is this much shorter than the longest body of a datagram, so that its group's parity fits into one.
inline constexpr size_t kParityOverhead = kParityHeaderBytes + kShardLengthBytes;

struct ParityHeader {
  FrameId frame;
  uint16_t slice_count = 0;  // of the frame
  uint16_t groups = 0;
  uint16_t group = 0;
  uint8_t index = 0;  // of the group's parity shards
  uint8_t reserved = 0;
  friend bool operator==(const ParityHeader&, const ParityHeader&) = default;
};

struct FrameParity {
  ParityHeader header;
  std::span<const uint8_t> shard;  // borrowed from the datagram
};

// Slices of a group: group, group + groups, group + 2 * groups ...
inline size_t slices_of_group(const ParityHeader& h) {
  return (size_t{h.slice_count} - h.group + h.groups - 1) / h.groups;
}

// Total; allocates nothing.
std::optional<FrameParity> decode_parity(std::span<const uint8_t> body);
void append_parity(std::vector<uint8_t>& out, const ParityHeader& header, std::span<const uint8_t> shard);

using Bodies = std::vector<std::span<const uint8_t>>;

// `count` parity shards of a group's slice bodies (1 to kMaxGroupSlices of them; count 1 to kMaxGroupParity).
std::vector<std::vector<uint8_t>> make_parity(const Bodies& bodies, size_t count);

struct ParityShard {
  uint8_t index = 0;
  std::span<const uint8_t> bytes;
};

// The missing bodies (`bodies` has an empty span in their place), in their order. Empty: there are fewer shards than
// missing bodies, or they are not of one code word.
std::vector<std::vector<uint8_t>> rebuild(const Bodies& bodies, std::span<const ParityShard> parity);

}  // namespace gnomon::protocol
