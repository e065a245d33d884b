// Forward error correction of a frame: its slices are divided into groups, and from a group's parity shards as many of
// its lost slices can be rebuilt. A Cauchy Reed-Solomon code over GF(2^8) (J. Bloemer and others, "An XOR-Based
// Erasure-Resilient Coding Scheme", 1995), computed with Intel ISA-L. WIRE.md has the format.
//
// Slice s is in group s % groups, so that a burst of losses spreads over many groups. A slice's shard is its body's
// length (u16), the body, and zeros up to the length of its group's longest shard.
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
// With parity, a slice's body is at least this much shorter than the longest body of a datagram, so that a parity shard
// of its group fits into one.
inline constexpr size_t kParityOverhead = kParityHeaderBytes + kShardLengthBytes;

struct ParityHeader {
  FrameId frame;
  uint16_t slice_count = 0;  // of the frame
  uint16_t groups = 0;
  uint16_t group = 0;
  uint8_t index = 0;  // of this shard among the group's parity shards
  uint8_t reserved = 0;
  friend bool operator==(const ParityHeader&, const ParityHeader&) = default;
};

struct FrameParity {
  ParityHeader header;
  std::span<const uint8_t> shard;  // borrowed from the datagram
};

// The number of slices in the header's group: group, group + groups, group + 2 * groups ...
inline size_t slices_of_group(const ParityHeader& h) {
  return (size_t{h.slice_count} - h.group + h.groups - 1) / h.groups;
}

// Total: any bytes give a FrameParity that borrows from `body`, or nullopt. Allocates nothing.
std::optional<FrameParity> decode_parity(std::span<const uint8_t> body);
void append_parity(std::vector<uint8_t>& out, const ParityHeader& header, std::span<const uint8_t> shard);

using Bodies = std::vector<std::span<const uint8_t>>;

// Returns `count` parity shards (1 to kMaxGroupParity) of a group's slice bodies (1 to kMaxGroupSlices of them, none
// empty).
std::vector<std::vector<uint8_t>> make_parity(const Bodies& bodies, size_t count);

struct ParityShard {
  uint8_t index = 0;
  std::span<const uint8_t> bytes;
};

// Returns the missing bodies in their order; `bodies` has an empty span in the place of each. Empty if none is missing,
// if there are fewer shards than missing bodies, or if shards and bodies evidently do not belong together.
std::vector<std::vector<uint8_t>> rebuild(const Bodies& bodies, std::span<const ParityShard> parity);

}  // namespace gnomon::protocol
