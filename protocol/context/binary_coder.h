// Arithmetic coding of single bits with given probabilities: a range coder with carry propagation, after G. N. N.
// Martin, "Range encoding" (1979), in the form of LZMA's (I. Pavlov): 32 bits of range, bytes out.
//
// No library fits: those packaged code bytes or symbols with models of their own, while here each bit's probability
// comes from outside and the encoder must know after any bit how long the payload would be if it ended there.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace gnomon::protocol::context {

// Of a bit being 1, in 1/65536. Coders need 1 to 65535.
using Probability = uint32_t;

inline constexpr uint32_t kLeastRange = 1u << 24;

class BinaryEncoder {
 public:
  static constexpr bool kDecodes = false;

  // A place to return to.
  struct Mark {
    size_t bytes = 0, waiting = 0;
    uint64_t low = 0;
    uint32_t range = 0;
    uint8_t cache = 0;
    bool started = false;
  };

  // Appends to `out`, which outlives the coder.
  explicit BinaryEncoder(std::vector<uint8_t>& out) : out_(out) {}

  bool code(bool bit, Probability one) {
    const uint32_t bound = (range_ >> 16) * one;
    if (bit) {
      range_ = bound;
    } else {
      low_ += bound;
      range_ -= bound;
    }
    while (range_ < kLeastRange) {
      range_ <<= 8;
      shift();
    }
    return bit;
  }

  // Bytes that `out` has at most if the coder ends now.
  size_t size() const { return out_.size() + waiting_ + kTail; }

  Mark mark() const { return {out_.size(), waiting_, low_, range_, cache_, started_}; }
  void return_to(const Mark& mark) {
    out_.resize(mark.bytes);
    waiting_ = mark.waiting;
    low_ = mark.low;
    range_ = mark.range;
    cache_ = mark.cache;
    started_ = mark.started;
  }

  // Writes what is left. A decoder takes zeros for what is behind the end, so those at the end are not written.
  void finish() {
    const size_t begin = begin_;
    for (uint32_t bits = 31; bits > 0; --bits) {  // the roundest number that lies within the range
      const uint64_t mask = (uint64_t{1} << bits) - 1;
      const uint64_t rounded = (low_ + mask) & ~mask;
      if (rounded - low_ >= range_) continue;
      low_ = rounded;
      break;
    }
    for (int i = 0; i < 5; ++i) shift();
    while (out_.size() > begin && out_.back() == 0) out_.pop_back();
  }

 private:
  static constexpr size_t kTail = 5;

  // The highest byte leaves. While it is 255 a carry may still run through it: then it waits.
  void shift() {
    if (low_ < 0xff000000u || low_ > 0xffffffffu) {
      const auto carry = static_cast<uint8_t>(low_ >> 32);
      if (started_) out_.push_back(static_cast<uint8_t>(cache_ + carry));
      started_ = true;
      for (; waiting_ > 0; --waiting_) out_.push_back(static_cast<uint8_t>(0xff + carry));
      cache_ = static_cast<uint8_t>(low_ >> 24);
    } else {
      ++waiting_;
    }
    low_ = (low_ & 0x00ffffffu) << 8;
  }

  std::vector<uint8_t>& out_;
  size_t begin_ = out_.size();
  uint64_t low_ = 0;
  uint32_t range_ = 0xffffffff;
  size_t waiting_ = 0;
  uint8_t cache_ = 0;
  bool started_ = false;  // the first byte that would leave is always 0
};

// Any bytes give some bits.
class BinaryDecoder {
 public:
  static constexpr bool kDecodes = true;

  explicit BinaryDecoder(std::span<const uint8_t> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) value_ = value_ << 8 | next();
  }

  bool code(bool, Probability one) {
    const uint32_t bound = (range_ >> 16) * one;
    if (value_ < bound) {
      // A branch and no conditional move: what comes next need not wait for the bit where it was foreseen.
      __asm__ volatile("");
      range_ = bound;
      fill();
      return true;
    }
    value_ -= bound;
    range_ -= bound;
    fill();
    return false;
  }

  // Whether all bytes were looked at: none is left that an encoder would not have written.
  bool at_end() const { return taken_ >= bytes_.size(); }

 private:
  void fill() {
    while (range_ < kLeastRange) {
      range_ <<= 8;
      value_ = value_ << 8 | next();
    }
  }
  uint8_t next() { return taken_ < bytes_.size() ? bytes_[taken_++] : uint8_t{0}; }

  std::span<const uint8_t> bytes_;
  size_t taken_ = 0;
  uint32_t range_ = 0xffffffff;
  uint32_t value_ = 0;
};

}  // namespace gnomon::protocol::context
