// A bitmap, eight pixels per byte, the leftmost in the lowest bit, with margins that may be read beyond its edges.
#pragma once

#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "common/tile_mask.h"

namespace gnomon::protocol::context {

class BitRows {
 public:
  static constexpr int kMarginRows = 32;
  static constexpr int kMarginBytes = 4;  // to the left
  static constexpr int kRightMarginBytes = 16;

  // Takes that size, all pixels and margins 0.
  void reset(uint32_t tiles_x, uint32_t tiles_y) {
    tiles_x_ = static_cast<int>(tiles_x);
    tiles_y_ = static_cast<int>(tiles_y);
    stride_ = tiles_x_ + kMarginBytes + kRightMarginBytes;
    bytes_.assign(static_cast<size_t>(stride_) * static_cast<size_t>(tiles_y_ * 8 + 2 * kMarginRows), 0);
  }

  int width() const { return tiles_x_ * 8; }
  int height() const { return tiles_y_ * 8; }

  // The byte of pixel row `y` in tile column `tile_x`; `y` is at least -kMarginRows.
  uint8_t* at(int tile_x, int y) {
    return bytes_.data() + static_cast<ptrdiff_t>(y + kMarginRows) * stride_ + tile_x + kMarginBytes;
  }
  const uint8_t* at(int tile_x, int y) const { return const_cast<BitRows*>(this)->at(tile_x, y); }

  void put(int tile_x, int tile_y, uint64_t word) {
    uint8_t* byte = at(tile_x, tile_y * 8);
    for (int row = 0; row < 8; ++row, byte += stride_) *byte = static_cast<uint8_t>(word >> 8 * row);
  }
  uint64_t get(int tile_x, int tile_y) const {
    uint64_t word = 0;
    for (int row = 0; row < 8; ++row) word |= uint64_t{*at(tile_x, tile_y * 8 + row)} << 8 * row;
    return word;
  }

  // The 32 pixels of row `y` from `x` on, leftmost in the lowest bit; `x` is at least -8 * kMarginBytes.
  uint32_t window(int x, int y) const {
    uint64_t bits;
    std::memcpy(&bits, at(0, y) + (x >> 3), sizeof bits);
    return static_cast<uint32_t>(bits >> (x & 7));
  }

  // The 64 pixels of row `y` from `x` on, likewise.
  uint64_t wide_window(int x, int y) const {
    const uint8_t* from = at(0, y) + (x >> 3);
    uint64_t bits;
    std::memcpy(&bits, from, sizeof bits);
    return bits >> (x & 7) | uint64_t{from[8]} << 1 << (63 - (x & 7));
  }

  // Fills the margins with the pixels at the bitmap's edges.
  void extend() {
    for (int y = 0; y < height(); ++y) {
      std::memset(at(-kMarginBytes, y), (*at(0, y) & 1) != 0 ? 0xff : 0, kMarginBytes);
      std::memset(at(tiles_x_, y), (*at(tiles_x_ - 1, y) & 0x80) != 0 ? 0xff : 0, kRightMarginBytes);
    }
    for (int i = 1; i <= kMarginRows; ++i) {
      std::memcpy(at(-kMarginBytes, -i), at(-kMarginBytes, 0), static_cast<size_t>(stride_));
      std::memcpy(at(-kMarginBytes, height() + i - 1), at(-kMarginBytes, height() - 1),
                  static_cast<size_t>(stride_));
    }
    find_even();
  }

  // Whether all pixels of a square from (x, y) on, whose side is at most 17, have that value. Only of what has been
  // extended.
  bool is_even(int x, int y, int side, bool lit) const {
    if (even_[even_at(x >> 3, y >> 3)] == (lit ? kLit : kDark)) return true;
    const uint32_t columns = (1u << side) - 1, value = lit ? columns : 0;
    for (int row = y; row < y + side; ++row)
      if ((window(x, row) & columns) != value) return false;
    return true;
  }

 private:
  enum Even : uint8_t { kNot = 0, kDark = 1, kLit = 2 };

  size_t even_at(int tile_x, int tile_y) const {
    return static_cast<size_t>((tile_y + kMarginRows / 8) * stride_ + tile_x + kMarginBytes);
  }

  // Finds for each tile whether it and those to the right and below, 3x3 in all, are even: most of them are, and one
  // look-up then replaces those of all rows.
  void find_even() {
    const auto stride = static_cast<size_t>(stride_), rows = bytes_.size() / stride / 8;
    std::vector<uint8_t> tiles(rows * stride), across(rows * stride);
    for (size_t row = 0; row < rows; ++row)
      for (size_t x = 0; x < stride; ++x) {
        uint8_t any = 0, all = 0xff;
        for (size_t y = 0; y < 8; ++y) {
          const uint8_t byte = bytes_[(row * 8 + y) * stride + x];
          any |= byte;
          all &= byte;
        }
        tiles[row * stride + x] = static_cast<uint8_t>((any == 0 ? kDark : 0) | (all == 0xff ? kLit : 0));
      }
    for (size_t i = 0; i + 2 < tiles.size(); ++i)
      across[i] = static_cast<uint8_t>(tiles[i] & tiles[i + 1] & tiles[i + 2]);
    even_.assign(rows * stride, kNot);
    for (size_t i = 0; i + 2 * stride < across.size(); ++i)
      even_[i] = static_cast<uint8_t>(across[i] & across[i + stride] & across[i + 2 * stride]);
  }

  int tiles_x_ = 0, tiles_y_ = 0, stride_ = 0;
  std::vector<uint8_t> bytes_;
  std::vector<uint8_t> even_;  // of what has been extended
};

}  // namespace gnomon::protocol::context
