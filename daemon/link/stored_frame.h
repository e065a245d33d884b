// A frame that was handed over for sending, kept until it is of no more use: its slices' bodies, their parity, and
// what became of each. Pure.
#pragma once

#include <vector>

#include "common/clock.h"
#include "protocol/codec.h"
#include "protocol/parity.h"

namespace gnomon::daemon {

class StoredFrame {
 public:
  // The slices' headers are complete. `pad`: slices that are nearly as long as the longest become as long, so that the
  // kernel can cut them from one buffer.
  StoredFrame(const protocol::EncodedFrame& slices, uint64_t answer, TimePoint deadline, bool pad = false);

  FrameId frame() const { return frame_; }
  uint64_t answer() const { return answer_; }  // the link's number for it
  // The client's deadline; where it has said none, as long as it will wait for more after the last datagram.
  TimePoint useful_until() const;
  void sent(TimePoint now) { last_sent_ = now; }
  size_t slice_count() const { return state_.size(); }
  size_t bytes() const { return bytes_.size(); }
  std::span<const uint8_t> body(uint16_t slice) const {
    return std::span(bytes_).subspan(offsets_[slice], offsets_[slice + 1] - offsets_[slice]);
  }

  // Makes parity against that share of losses.
  void protect(double loss);
  size_t parity_count() const { return parity_.size(); }
  std::span<const uint8_t> parity_body(uint16_t number) const { return parity_[number].body; }

  void slice_arrived(uint16_t slice) {
    state_[slice] = State::arrived;
    any_arrived_ = true;
  }
  bool any_arrived() const { return any_arrived_; }
  void parity_lost(uint16_t number) { parity_[number].lost = true; }
  // True: the client can no longer rebuild it and it should go again.
  bool slice_lost(uint16_t slice);

 private:
  enum class State : uint8_t { sent, arrived, lost };
  struct Parity {
    std::vector<uint8_t> body;
    uint16_t group = 0;
    bool lost = false;
  };

  FrameId frame_;
  uint64_t answer_;
  TimePoint deadline_;
  TimePoint last_sent_ = TimePoint::max();
  std::vector<uint8_t> bytes_;
  std::vector<size_t> offsets_{0};
  std::vector<State> state_;  // of each slice
  bool any_arrived_ = false;
  uint16_t groups_ = 1;
  std::vector<Parity> parity_;
};

}  // namespace gnomon::daemon
