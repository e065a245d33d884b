#include "protocol/tile_code.h"

#include <array>
#include <bit>

namespace gnomon::protocol {
namespace {

// The runs of ones that touch a side of a row, as a ring in which neighbours differ by one pixel: number n <= 8 has its
// n lowest bits set, number n > 8 its 16 - n highest.
constexpr std::array<uint8_t, 16> kRing = {0x00, 0x01, 0x03, 0x07, 0x0f, 0x1f, 0x3f, 0x7f,
                                           0xff, 0xfe, 0xfc, 0xf8, 0xf0, 0xe0, 0xc0, 0x80};
constexpr uint8_t kNotInRing = 0xff;

constexpr auto kRingNumbers = [] {
  std::array<uint8_t, 256> numbers{};
  numbers.fill(kNotInRing);
  for (uint8_t n = 0; n < kRing.size(); ++n) numbers[kRing[n]] = n;
  return numbers;
}();

// A line's first byte has the first row's number in bits 0 to 3 and these flags. Bit i of its second byte says whether
// row i + 1 is one step away from row i.
constexpr uint8_t kStepsDown = 0x10;
constexpr uint8_t kColumns = 0x20;

constexpr unsigned row_of(uint64_t word, int row) { return (word >> (row * 8)) & 0xff; }

// Transposes the 8x8 bit matrix in three rounds of swaps (H. S. Warren, "Hacker's Delight", 7-3).
uint64_t transposed(uint64_t word) {
  const auto swap = [&word](int distance, uint64_t mask) {
    const uint64_t differs = (word ^ (word >> distance)) & mask;
    word ^= differs ^ (differs << distance);
  };
  swap(7, 0x00aa00aa00aa00aa);
  swap(14, 0x0000cccc0000cccc);
  swap(28, 0x00000000f0f0f0f0);
  return word;
}

// Returns whether the rows make a line; if so, `flags` and `steps` are its two bytes.
bool find_line(uint64_t word, uint8_t& flags, uint8_t& steps) {
  unsigned number = kRingNumbers[row_of(word, 0)];
  if (number == kNotInRing) return false;
  flags = static_cast<uint8_t>(number);
  unsigned up = 0;
  unsigned down = 0;
  for (int row = 1; row < 8; ++row) {
    const unsigned next = kRingNumbers[row_of(word, row)];
    const unsigned step = (next - number) & 0x0f;
    if (next == kNotInRing || (step != 0 && step != 1 && step != 15)) return false;
    up |= static_cast<unsigned>(step == 1) << (row - 1);
    down |= static_cast<unsigned>(step == 15) << (row - 1);
    number = next;
  }
  if (up != 0 && down != 0) return false;
  if (down != 0) flags |= kStepsDown;
  steps = static_cast<uint8_t>(up | down);
  return true;
}

uint64_t line_word(uint8_t flags, uint8_t steps) {
  const unsigned step = (flags & kStepsDown) != 0 ? 15 : 1;
  unsigned number = flags & 0x0fu;
  uint64_t word = kRing[number];
  for (int row = 1; row < 8; ++row) {
    number = (number + ((steps >> (row - 1)) & 1) * step) & 0x0f;
    word |= uint64_t{kRing[number]} << (row * 8);
  }
  return (flags & kColumns) != 0 ? transposed(word) : word;
}

void encode_rows(uint64_t word, uint8_t*& out) {
  const uint64_t differs = word ^ (word << 8);
  uint8_t* const mask = out++;
  *mask = 0;
  for (int row = 0; row < 8; ++row) {
    *out = static_cast<uint8_t>(row_of(word, row));
    const bool is_new = row_of(differs, row) != 0;
    *mask = static_cast<uint8_t>(*mask | unsigned{is_new} << row);
    out += is_new ? 1 : 0;  // otherwise the next row overwrites this one
  }
}

}  // namespace

TileClass encode_tile(uint64_t word, uint8_t*& out) {
  uint8_t flags = 0;
  uint8_t steps = 0;
  bool line = find_line(word, flags, steps);
  if (!line && find_line(transposed(word), flags, steps)) {
    flags |= kColumns;
    line = true;
  }
  if (!line) {
    encode_rows(word, out);
    return TileClass::rows;
  }
  *out++ = flags;
  *out++ = steps;
  return TileClass::line;
}

bool decode_tile(TileClass tile_class, std::span<const uint8_t>& bytes, uint64_t& word) {
  if (bytes.empty()) return false;
  const uint8_t first = bytes[0];
  const size_t size = tile_class == TileClass::line ? 2 : 1 + static_cast<size_t>(std::popcount(first));
  if (bytes.size() < size) return false;
  if (tile_class == TileClass::line) {
    word = line_word(first, bytes[1]);
  } else {
    uint64_t row = 0;
    size_t next = 1;
    word = 0;
    for (int r = 0; r < 8; ++r) {
      if ((first >> r & 1) != 0) row = bytes[next++];
      word |= row << (r * 8);
    }
  }
  bytes = bytes.subspan(size);
  return true;
}

}  // namespace gnomon::protocol
