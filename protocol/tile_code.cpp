#include "protocol/tile_code.h"

#include <array>
#include <bit>

namespace gnomon::protocol {
namespace {

// The runs of ones that touch a side of a row, as a ring in which neighbours differ by one pixel: number n <= 8 has its
// n lowest bits set, number n > 8 its 16 - n highest.
constexpr std::array<uint8_t, 16> kRing = {0x00, 0x01, 0x03, 0x07, 0x0f, 0x1f, 0x3f, 0x7f,
                                           0xff, 0xfe, 0xfc, 0xf8, 0xf0, 0xe0, 0xc0, 0x80};

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

// The functions below compute with the eight rows of a tile at once, a byte each.
constexpr uint64_t kEach = 0x0101010101010101;  // times a byte: that byte in each row

// Whether each row is in the ring: its pixels change at most once from left to right.
bool all_in_ring(uint64_t word) {
  const uint64_t changes = (word ^ word >> 1) & kEach * 0x7f;
  const uint64_t less_one = (changes | kEach * 0x80) - kEach;
  return (changes & less_one & kEach * 0x7f) == 0;
}

// The ring numbers of rows that are in the ring: as many as they have ones if the lowest bit is one of these or all are 0.
uint64_t ring_numbers(uint64_t word) {
  uint64_t ones = word - (word >> 1 & kEach * 0x55);
  ones = (ones & kEach * 0x33) + (ones >> 2 & kEach * 0x33);
  ones = (ones + (ones >> 4)) & kEach * 0x0f;
  const uint64_t from_right = (word & kEach) * 0xff;
  return (ones & from_right) | ((kEach * 16 - ones) & kEach * 0x0f & ~from_right);
}

// Bit i of the result is the lowest of row i; each row is 0 or 1.
uint8_t lowest_bits(uint64_t rows) { return static_cast<uint8_t>(rows * 0x0102040810204080 >> 56); }

// Returns whether the rows make a line; if so, `flags` and `steps` are its two bytes.
bool find_line(uint64_t word, uint8_t& flags, uint8_t& steps) {
  if (!all_in_ring(word)) return false;
  const uint64_t numbers = ring_numbers(word);
  // From each row to the one below, plus 1: 0 for a step down, 1 for none, 2 for one up.
  const uint64_t moves = ((numbers >> 8 | kEach * 0x10) - (numbers & ~uint64_t{0} >> 8) + kEach) & kEach * 0x0f;
  const uint64_t between = ~uint64_t{0} >> 8;  // the last row has none below
  const uint64_t up = moves >> 1 & kEach, same = moves & kEach;
  const bool single = ((moves & kEach * 0x0c) | (up & same)) << 8 == 0;
  const uint64_t down = ~(up | same) & kEach & between;
  if (!single || ((up & between) != 0 && down != 0)) return false;
  flags = static_cast<uint8_t>((numbers & 0x0f) | (down != 0 ? kStepsDown : 0));
  steps = lowest_bits((up & between) | down);
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
