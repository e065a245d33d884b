// A frame that was handed over for sending, kept as long as the client can use it: the bodies of its slices, their
// parity, and whether each has arrived or is lost. Pure.
#pragma once

#include <vector>

#include "common/clock.h"
#include "protocol/codec.h"
#include "protocol/parity.h"

namespace gnomon::daemon {

class StoredFrame {
 public:
  // Precondition: the slices' headers are complete. `pad`: slices that are nearly as long as the longest are padded to
  // its length, so that the kernel can cut them from one buffer (segmentation offload, data_socket.h).
  StoredFrame(const protocol::EncodedMask& slices, uint64_t answer, TimePoint deadline, bool pad = false);

  FrameId frame() const { return frame_; }
  uint64_t answer() const { return answer_; }  // LinkSender's number of the frame
  // The client's deadline; if it has set none, the time for which it waits for more after the last datagram.
  TimePoint useful_until() const;
  void sent(TimePoint now) { last_sent_ = now; }
  size_t slice_count() const { return state_.size(); }
  size_t bytes() const { return bytes_.size(); }
  std::span<const uint8_t> body(uint16_t slice) const {
    return std::span(bytes_).subspan(offsets_[slice], offsets_[slice + 1] - offsets_[slice]);
  }

  // Makes parity for an expected share `loss` of lost datagrams.
  void protect(double loss);
  size_t parity_count() const { return parity_.size(); }
  std::span<const uint8_t> parity_body(uint16_t number) const { return parity_[number].body; }

  void slice_arrived(uint16_t slice) {
    state_[slice] = State::arrived;
    any_arrived_ = true;
  }
  bool any_arrived() const { return any_arrived_; }
  void parity_lost(uint16_t number) { parity_[number].lost = true; }
  // True if the client can no longer rebuild the slice, so that it should be sent again.
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
