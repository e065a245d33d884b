// Arithmetic coding of single bits with given probabilities: a range coder with carry propagation, after G. N. N.
// Martin, "Range encoding: an algorithm for removing redundancy from a digitised message" (1979), in the form that LZMA
// (I. Pavlov) uses: a range of 32 bits, output in bytes.
//
// No library fits: the packaged ones code bytes or symbols with models of their own, while here the caller supplies
// each bit's probability and must know after any bit how long the payload would be if it ended there.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace gnomon::protocol::context {

// The probability of a bit being 1, in units of 1/65536. Coders accept 1 to 65535.
using Probability = uint32_t;

inline constexpr uint32_t kLeastRange = 1u << 24;

class BinaryEncoder {
 public:
  static constexpr bool kDecodes = false;
  static constexpr size_t kTail = 5;  // bytes that size() counts for what is pending

  // A state of the coder and of its output to which return_to() goes back.
  struct Mark {
    size_t bytes = 0, waiting = 0;
    uint64_t low = 0;
    uint32_t range = 0;
    uint8_t cache = 0;
    bool started = false;
  };

  // Appends to `out`, which must outlive the coder.
  explicit BinaryEncoder(std::vector<uint8_t>& out) : out_(out) {}

  bool code(bool bit, Probability one) {
    const uint32_t bound = (range_ >> 16) * one;
    const uint32_t zero = 0 - uint32_t{!bit};  // without branches, which are mispredicted too often
    low_ += bound & zero;
    range_ = bit ? bound : range_ - bound;
    while (__builtin_expect(range_ < kLeastRange, 0)) {
      range_ <<= 8;
      shift();
    }
    return bit;
  }

  // An upper bound of the size that `out` would have if finish() were called now.
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

  // Writes what is pending. A decoder reads zeros behind the end, so trailing zeros are not written.
  void finish() {
    const size_t begin = begin_;
    for (uint32_t bits = 31; bits > 0; --bits) {  // the number in the range with most trailing zeros
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
  // Outputs the highest byte. If it is 255, a later carry may still propagate through it, so it is held back.
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
  bool started_ = false;  // the first byte is always 0 and is not written
};

// Decodes any bytes to some bits.
class BinaryDecoder {
 public:
  static constexpr bool kDecodes = true;

  explicit BinaryDecoder(std::span<const uint8_t> bytes) : bytes_(bytes) {
    for (int i = 0; i < 4; ++i) value_ = value_ << 8 | next();
  }

  bool code(bool, Probability one) {
    const uint32_t bound = (range_ >> 16) * one;
    if (value_ < bound) {
      // Forces a branch instead of a conditional move, so that correctly predicted bits do not delay what follows.
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

  // Whether all bytes have been read. An encoder writes none that its decoder does not read.
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
