// A sliding window that records which of the last 1,024 sequence numbers have been seen, as IPsec's against replay
// (RFC 4303, 3.4.3). Older numbers count as seen, and so does 0.
#pragma once

#include <bitset>
#include <cstdint>

namespace gnomon::protocol {

class ReplayWindow {
 public:
  static constexpr uint64_t kSize = 1024;

  // All numbers up to `newest` count as seen.
  explicit ReplayWindow(uint64_t newest = 0) : newest_(newest) { seen_.set(); }

  uint64_t newest() const { return newest_; }

  bool is_new(uint64_t sequence) const {
    return sequence > newest_ || (newest_ - sequence < kSize && !seen_[sequence % kSize]);
  }

  // Records `sequence`; false if it counted as seen before. Precondition: its datagram is authentic.
  bool take(uint64_t sequence) {
    if (!is_new(sequence)) return false;
    if (sequence > newest_) forget(sequence);
    seen_.set(sequence % kSize);
    return true;
  }

 private:
  // Advances the window to `sequence`, with the numbers in between marked as not seen.
  void forget(uint64_t sequence) {
    if (sequence - newest_ >= kSize) {
      seen_.reset();
    } else {
      while (newest_ != sequence) seen_.reset(++newest_ % kSize);
    }
    newest_ = sequence;
  }

  uint64_t newest_;
  std::bitset<kSize> seen_;
};

}  // namespace gnomon::protocol
