// Which slice went in which datagram, until it is told what became of it. Pure.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <optional>

namespace gnomon::daemon {

class SentSlices {
 public:
  struct Slice {
    uint64_t answer = 0;  // StoredFrame::answer()
    uint16_t number = 0;
  };

  // Sequence numbers increase from call to call.
  void add(uint64_t sequence, uint64_t answer, uint16_t number) {
    if (sent_.size() == kMost) sent_.pop_front();
    sent_.push_back({sequence, {answer, number}});
  }

  // nullopt if it carried none, was too long ago, or was told of before.
  std::optional<Slice> take(uint64_t sequence) {
    const auto found = std::lower_bound(sent_.begin(), sent_.end(), sequence,
                                        [](const Sent& sent, uint64_t wanted) { return sent.sequence < wanted; });
    if (found == sent_.end() || found->sequence != sequence || found->slice.answer == 0) return std::nullopt;
    const Slice slice = found->slice;
    found->slice.answer = 0;
    while (!sent_.empty() && sent_.front().slice.answer == 0) sent_.pop_front();
    return slice;
  }

 private:
  static constexpr size_t kMost = 1024;
  struct Sent {
    uint64_t sequence = 0;
    Slice slice;
  };
  std::deque<Sent> sent_;
};

}  // namespace gnomon::daemon
