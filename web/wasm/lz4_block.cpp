#include "web/wasm/lz4_block.h"

#include <cstring>

namespace gnomon::web {
namespace {

constexpr size_t kLeastMatch = 4;
constexpr size_t kLastLiterals = 5;    // a block's last bytes are literals
constexpr size_t kMatchEndLimit = 12;  // literals that end closer to the end of the room are the block's last
constexpr size_t kRestAfterLiterals = 2 + 1 + kLastLiterals;  // least bytes of a block behind literals with a match
// Where so much is left of both, the library takes a short way that does not look at the rules for their ends.
constexpr size_t kShortWayInput = 17, kShortWayRoom = 32, kShortWayDistance = 8;
constexpr size_t kLongLength = 15;  // in four bits: more follows

// Where the block is read.
class Input {
 public:
  explicit Input(std::span<const uint8_t> block) : left_(block) {}

  size_t left() const { return left_.size(); }
  // Precondition: something is left.
  uint8_t byte() { return take(1)[0]; }
  std::span<const uint8_t> take(size_t count) {
    const auto taken = left_.first(count);
    left_ = left_.subspan(count);
    return taken;
  }
  // Adds the bytes that continue a length, of which at least `rest` bytes of the block must be left behind each.
  bool lengthen(size_t& length, size_t rest) {
    for (uint8_t more = 255; more == 255;) {
      if (left() == 0) return false;
      more = byte();
      length += more;
      if (left() < rest) return false;
    }
    return true;
  }

 private:
  std::span<const uint8_t> left_;
};

// Copies `length` bytes from `distance` before the end of what is written; both may overlap, which repeats bytes. A
// distance of 0, which the format does not know, gives zeros.
void repeat(uint8_t* at, size_t distance, size_t length) {
  if (distance == 0) {
    std::memset(at, 0, length);
  } else if (distance == 1) {
    std::memset(at, at[-1], length);
  } else if (distance >= length) {
    std::memcpy(at, at - distance, length);
  } else {
    for (size_t i = 0; i < length; ++i) at[i] = at[static_cast<ptrdiff_t>(i) - static_cast<ptrdiff_t>(distance)];
  }
}

}  // namespace

std::optional<size_t> unpack_lz4_block(std::span<const uint8_t> block, std::span<uint8_t> out) {
  Input input(block);
  size_t written = 0;
  while (input.left() > 0) {
    const uint8_t token = input.byte();
    size_t literals = token >> 4;
    if (literals == kLongLength && (input.left() <= kLongLength || !input.lengthen(literals, kLongLength))) {
      return std::nullopt;
    }
    const size_t room = out.size() - written;
    const bool short_way = literals < kLongLength && input.left() >= kShortWayInput && room >= kShortWayRoom;
    if (!short_way && (literals + kMatchEndLimit > room || literals + kRestAfterLiterals > input.left())) {
      // The last literals: they end both.
      if (literals != input.left() || literals > room) return std::nullopt;
      if (literals > 0) std::memcpy(&out[written], input.take(literals).data(), literals);
      return written + literals;
    }
    if (literals > 0) std::memcpy(&out[written], input.take(literals).data(), literals);
    written += literals;
    const auto low = input.byte();
    const size_t distance = low | size_t{input.byte()} << 8;
    size_t length = token & 15;
    if (length == kLongLength && !input.lengthen(length, kLastLiterals - 1)) return std::nullopt;
    length += kLeastMatch;
    const bool is_short = short_way && length < kLongLength + kLeastMatch && distance >= kShortWayDistance;
    const size_t end = is_short ? 0 : kLastLiterals;
    if (distance > written || length + end > out.size() - written) return std::nullopt;
    repeat(&out[written], distance, length);
    written += length;
  }
  return std::nullopt;
}

}  // namespace gnomon::web
