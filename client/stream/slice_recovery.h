// Rebuilds lost slices from parity: keeps the slices of the newest frames and their parity until both together suffice.
// One thread. Memory is bounded by kFrames and kMaxFrameBytes.
#pragma once

#include <deque>
#include <vector>

#include "protocol/datagram.h"
#include "protocol/parity.h"

namespace gnomon::client {

class SliceRecovery {
 public:
  static constexpr size_t kFrames = 4;
  static constexpr size_t kMaxFrameBytes = 32 << 20;

  // Add the body of a slice that arrived, or a parity shard. Both return the bodies of the slices that can be rebuilt
  // now, which count as arrived from then on.
  std::vector<std::vector<uint8_t>> add_slice(const protocol::SliceHeader& header, std::span<const uint8_t> body);
  std::vector<std::vector<uint8_t>> add_parity(const protocol::FrameParity& parity);

  // Parity shards that are kept, of all frames.
  size_t shards() const {
    size_t sum = 0;
    for (const Frame& frame : frames_) sum += frame.parity.size();
    return sum;
  }

 private:
  struct Shard {
    uint16_t group = 0;
    uint8_t index = 0;
    std::vector<uint8_t> bytes;
  };
  struct Frame {
    FrameId frame;
    uint16_t groups = 0;                       // 0: no parity yet
    std::vector<std::vector<uint8_t>> slices;  // bodies; if empty, it has not arrived
    std::vector<Shard> parity;
    size_t bytes = 0;
  };

  Frame* find_or_begin(FrameId frame, uint16_t slice_count);
  static std::vector<std::vector<uint8_t>> rebuild_group(Frame& frame, uint16_t group);

  std::deque<Frame> frames_;  // by increasing frame
};

}  // namespace gnomon::client
