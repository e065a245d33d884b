// The order in which a slice's decisions are coded, and the context of each. One template serves the encoder, the
// decoder and the recorder of the nets' training data, so that they cannot disagree.
//
// Tiles are coded row by row. A row of tiles is divided into segments. In a segment come first the motions of blocks
// that it is the first to reach, then the classes of all tiles, then the pixels of the mixed ones: pixel row by pixel
// row through the segment, as in JBIG (ITU-T T.82) and JBIG2's refinement (T.88), so that the context of each pixel
// includes what is above it on both sides.
#pragma once

#include <cassert>
#include <span>

#include "protocol/context/bit_rows.h"
#include "protocol/context/slice_model.h"

namespace gnomon::protocol::context {

inline constexpr uint32_t kSegment = 32;  // tiles; segments end at its multiples
inline constexpr uint32_t kBlock = 8;     // tiles; side of a block, which has one motion

// Working memory of a walk, reused by the next.
struct WalkMemory {
  BitRows rows;
  std::vector<uint8_t> classes;  // with margins
  std::vector<Motion> motions, motions_above;
  std::vector<uint8_t> has_motion, had_motion;
};

// One light's tiles: what a walk reads when it encodes, and where it writes what a decoder has.
struct LightTiles {
  std::span<const PackedClass> classes;  // empty in a decoder
  std::span<uint64_t> words;             // those of the walk's tiles are replaced
  const BitRows* reference = nullptr;
  std::span<const Motion> motions;  // for each block, row by row; empty in a decoder
};

// The end of the segment that `tile` is in.
inline uint32_t segment_end(uint32_t tile, uint32_t tiles_x) {
  const uint32_t x = tile % tiles_x;
  return tile - x + std::min((x / kSegment + 1) * kSegment, tiles_x);
}

template <class Coder, class Model>
class TileWalk {
 public:
  // Precondition: `memory.rows` has the grid's size. The references outlive the walk.
  TileWalk(Coder& coder, Model& model, const TileGrid& grid, WalkMemory& memory)
      : coder_(coder),
        model_(model),
        tiles_x_(grid.tiles_x()),
        stride_(grid.tiles_x() + 4),
        blocks_x_((grid.tiles_x() + kBlock - 1) / kBlock),
        memory_(memory) {
    memory.classes.resize(size_t{stride_} * (grid.tiles_y() + 2));
    memory.motions.resize(blocks_x_);
    memory.motions_above.resize(blocks_x_);
    memory.has_motion.resize(blocks_x_);
    memory.had_motion.resize(blocks_x_);
  }

  // Begins a light, whose first segment starts at tile `first`.
  void begin(const LightTiles& light, uint32_t first) {
    light_ = light;
    const auto row = static_cast<int>(first / tiles_x_);
    for (int y = row * 8 - 4; y < row * 8; ++y) clear_pixels(y);
    std::memset(class_at(0, row - 2) - 2, kOutside, size_t{stride_} * 2);
    std::fill(memory_.has_motion.begin(), memory_.has_motion.end(), uint8_t{0});
    enter_row(row);
    begin_motions();
  }

  // Codes the tiles [first, end), which are in one segment.
  void segment(uint32_t first, uint32_t end) {
    const auto row = static_cast<int>(first / tiles_x_);
    if (row != row_) {
      enter_row(row);
      if (row % int{kBlock} == 0) begin_motions();
    }
    const auto x0 = static_cast<int>(first % tiles_x_);
    const int x1 = x0 + static_cast<int>(end - first);
    if constexpr (Model::kReferenced) code_motions(x0, x1);
    mixed_count_ = 0;
    for (int x = x0; x < x1; ++x) code_class(x);
    for (int y = 0; y < 8; ++y)
      for (size_t i = 0; i < mixed_count_; ++i) code_pixels(mixed_[i], y);
    for (size_t i = 0; i < mixed_count_; ++i) word(mixed_[i]) = memory_.rows.get(mixed_[i], row_);
  }

 private:
  static constexpr bool kReferenced = Model::kReferenced;

  uint64_t& word(int x) { return light_.words[static_cast<size_t>(row_) * tiles_x_ + static_cast<size_t>(x)]; }
  uint8_t* class_at(int x, int row) { return &memory_.classes[static_cast<size_t>(row + 2) * stride_ + 2] + x; }

  void clear_pixels(int y) {
    std::memset(memory_.rows.at(-BitRows::kMarginBytes, y), 0,
                tiles_x_ + BitRows::kMarginBytes + BitRows::kRightMarginBytes);
  }
  void enter_row(int row) {
    row_ = row;
    for (int y = row * 8; y < row * 8 + 8; ++y) clear_pixels(y);
    std::memset(class_at(0, row) - 2, kOutside, stride_);
  }

  void begin_motions() {
    std::swap(memory_.motions, memory_.motions_above);
    std::swap(memory_.has_motion, memory_.had_motion);
    std::fill(memory_.has_motion.begin(), memory_.has_motion.end(), uint8_t{0});
  }
  void code_motions(int x0, int x1) {
    for (uint32_t block = static_cast<uint32_t>(x0) / kBlock; block * kBlock < static_cast<uint32_t>(x1); ++block) {
      if (memory_.has_motion[block]) continue;
      Motion motion;
      if constexpr (!Coder::kDecodes) {
        motion = light_.motions[static_cast<size_t>(row_) / kBlock * blocks_x_ + block];
      }
      memory_.motions[block] = model_.motion(coder_, motion, predicted_motion(block));
      memory_.has_motion[block] = 1;
    }
  }
  // The median of the left, above and above-right neighbours, as in H.263, if all are known; else the left one; else
  // the one above; else zero.
  Motion predicted_motion(uint32_t block) const {
    const bool left = block > 0 && memory_.has_motion[block - 1], above = memory_.had_motion[block];
    const bool right = block + 1 < blocks_x_ && memory_.had_motion[block + 1];
    if (left && above && right)
      return median(memory_.motions[block - 1], memory_.motions_above[block], memory_.motions_above[block + 1]);
    return left ? memory_.motions[block - 1] : above ? memory_.motions_above[block] : Motion{};
  }

  // The pixel of the reference at which a tile's counterpart begins, clamped to what its margins cover.
  struct Place {
    int x, y;
  };
  Place in_reference(int tile_x) const {
    const Motion motion = memory_.motions[static_cast<uint32_t>(tile_x) / kBlock];
    return {std::clamp(tile_x * 8 + motion.dx, -24, light_.reference->width() + 8),
            std::clamp(row_ * 8 + motion.dy, -24, light_.reference->height() + 8)};
  }

  void code_class(int x) {
    const uint8_t* here = class_at(x, row_);
    const uint8_t* above = class_at(x, row_ - 1);
    const uint8_t west = here[-1], north = above[0], north_east = above[1], north_west = above[-1];
    typename Model::Classes::Inputs inputs;
    bool quiet = west < kMixed && west == north && west == north_east && west == north_west;
    if constexpr (kReferenced) quiet = look_at_reference(x, inputs) == (west != 0 ? 0xff : 0) && quiet;
    PackedClass tile_class{};
    if constexpr (!Coder::kDecodes) {
      tile_class = light_.classes[static_cast<size_t>(row_) * tiles_x_ + static_cast<size_t>(x)];
    }
    uint8_t coded;
    if (quiet) {
      coded = model_.quiet_tile(coder_, tile_class, west != 0);
    } else {
      inputs[0] = static_cast<uint8_t>(west | north << 2 | north_east << 4 | north_west << 6);
      inputs[1] = static_cast<uint8_t>(here[-2] | class_at(x, row_ - 2)[0] << 2 | above[2] << 4 | above[-2] << 6);
      const uint8_t* last = memory_.rows.at(x, row_ * 8 - 1);
      inputs[2] = last[-1];
      inputs[3] = last[0];
      inputs[4] = last[1];
      inputs[5] = *memory_.rows.at(x, row_ * 8 - 2);
      const size_t edge = last[0] == 0 ? 0 : last[0] == 0xff ? 1 : 2;
      size_t other = size_t{last[0]} | size_t{west} << 8;
      if constexpr (kReferenced) other = size_t{inputs[6]} | size_t{west} << 8 | size_t{north} << 10;
      coded = model_.tile(coder_, tile_class, inputs, inputs[0] | edge << 8, other, west | north << 2);
    }
    *class_at(x, row_) = coded;
    if (coded == kMixed) {
      mixed_[mixed_count_++] = x;
      return;
    }
    const uint64_t uniform = coded == kLit ? ~uint64_t{0} : 0;
    word(x) = uniform;
    if (uniform != 0) memory_.rows.put(x, row_, uniform);
  }

  // Fills in the inputs of a class that are of the reference. Returns 0 if all is dark there, up to two pixels around,
  // 0xff if all is lit, else 1.
  uint8_t look_at_reference(int x, typename Model::Classes::Inputs& inputs) const {
    const Place at = in_reference(x);
    uint32_t any = 0, all = ~0u, any_half[2] = {0, 0}, all_half[2] = {~0u, ~0u}, left = 0, right = 0;
    uint32_t rows[12];
    for (int y = 0; y < 12; ++y) {
      const uint32_t row = rows[y] = light_.reference->window(at.x - 2, at.y + y - 2) & 0xfff;
      any |= row;
      all &= row;
      if (y < 2 || y > 9) continue;
      any_half[y > 5] |= row;
      all_half[y > 5] &= row;
      left |= (row & 1) << (y - 2);
      right |= (row >> 11) << (y - 2);
    }
    const auto inner = [](uint32_t row) { return row >> 2 & 0xff; };
    const uint32_t any_inner = inner(any_half[0] | any_half[1]), all_inner = inner(all_half[0] & all_half[1]);
    inputs[6] =
        static_cast<uint8_t>((any_inner != 0) | (all_inner == 0xff) << 1 | (any != 0) << 2 | (all == 0xfff) << 3 |
                             (inner(any_half[0]) != 0) << 4 | (inner(all_half[0]) == 0xff) << 5 |
                             (inner(any_half[1]) != 0) << 6 | (inner(all_half[1]) == 0xff) << 7);
    inputs[7] = static_cast<uint8_t>(inner(rows[2]));
    inputs[8] = static_cast<uint8_t>(inner(rows[9]));
    inputs[9] = static_cast<uint8_t>(inner(rows[0]));
    inputs[10] = static_cast<uint8_t>(inner(rows[11]));
    inputs[11] = static_cast<uint8_t>(left);
    inputs[12] = static_cast<uint8_t>(right);
    return any == 0 ? 0 : all == 0xfff ? 0xff : 1;
  }

  // Reads the windows of the reference's five rows around pixel row `y` of a tile; bit 8 is its leftmost pixel.
  void look_up_reference(int x, int y, uint32_t (&reference)[5]) const {
    const Place at = in_reference(x);
    for (int i = 0; i < 5; ++i) reference[i] = light_.reference->window(at.x - 8, at.y + y + i - 2);
  }

  // Codes one pixel row of a mixed tile.
  void code_pixels(int x, int y) {
    const int line = row_ * 8 + y;
    const BitRows& rows = memory_.rows;
    // In each window, bit 8 is the tile's leftmost pixel.
    const uint32_t above1 = window(rows, x, line - 1), above2 = window(rows, x, line - 2),
                   above3 = window(rows, x, line - 3), above4 = window(rows, x, line - 4);
    uint32_t reference[5] = {};
    if constexpr (kReferenced) look_up_reference(x, y, reference);
    uint32_t left = rows.at(x, line)[-1];
    uint8_t source = 0;
    if constexpr (!Coder::kDecodes) source = static_cast<uint8_t>(word(x) >> 8 * y);
    const auto line_place = static_cast<uint8_t>(y << 3 | *class_at(x + 1, row_) << 6);
    // Whether any pixel around is lit, and whether all are: in windows of 16 pixels (wide) and of eight.
    uint32_t any_wide = above1 | above2, all_wide = above1 & above2, any = above3, all = above3;
    if constexpr (kReferenced) {
      any |= any_wide;
      all &= all_wide;
      any_wide = 0;
      all_wide = ~0u;
      for (const uint32_t row : reference) {
        any |= row;
        all &= row;
      }
    } else {
      any |= above4;
      all &= above4;
    }
    for (int i = 0; i < 8; ++i) {
      const uint32_t lit = left | (any >> (5 + i) & 0xff) | (any_wide >> (1 + i) & 0xffff);
      const uint32_t dark = ~(left & (all >> (5 + i)) & (all_wide >> (1 + i)) & (all_wide >> (9 + i))) & 0xff;
      const bool source_bit = (source >> i & 1) != 0;
      const auto place = static_cast<uint8_t>(line_place | i);
      bool bit;
      if (lit == 0 || dark == 0) {
        bit = model_.run_pixel(coder_, source_bit, lit != 0, place);
      } else {
        typename Model::Pixels::Inputs inputs;
        const auto eight = [i](uint32_t row, int from) { return static_cast<uint8_t>(row >> (8 + i + from)); };
        inputs[0] = place;
        inputs[1] = static_cast<uint8_t>(left);
        if constexpr (kReferenced) {
          inputs[2] = eight(above1, -3);
          inputs[3] = eight(above2, -3);
          inputs[4] = eight(above3, -3);
          for (size_t r = 0; r < 5; ++r) inputs[5 + r] = eight(reference[r], -3);
        } else {
          inputs[2] = eight(above1, -7);
          inputs[3] = eight(above1, 1);
          inputs[4] = eight(above2, -7);
          inputs[5] = eight(above2, 1);
          inputs[6] = eight(above3, -3);
          inputs[7] = eight(above4, -3);
        }
        bit = code_pixel(inputs, above1 >> (5 + i), above2 >> (7 + i), reference, i, source_bit);
      }
      left = (left >> 1 | uint32_t{bit} << 7) & 0xff;
    }
    *memory_.rows.at(x, line) = static_cast<uint8_t>(left);
  }

  // Bit 0 of `above1` is the pixel three to the left, that of `above2` the one to the left.
  bool code_pixel(const typename Model::Pixels::Inputs& inputs, uint32_t above1, uint32_t above2,
                  const uint32_t (&reference)[5], int i, bool bit) {
    const uint32_t left = inputs[1];
    const uint32_t nearest = (left >> 7) | (above1 >> 2 & 7) << 1 | (left >> 6 & 1) << 4;  // bit 4: two to the left
    const size_t near = (left >> 4) | (above1 & 0x7f) << 4 | (above2 & 7) << 11;
    size_t other;
    if constexpr (kReferenced) {
      other = nearest | (reference[1] >> (7 + i) & 7) << 5 | (reference[2] >> (7 + i) & 7) << 8 |
              (reference[3] >> (7 + i) & 7) << 11;
    } else {
      other = size_t{inputs[0]} | size_t{nearest} << 8 | (above2 >> 1 & 1) << 13;
    }
    return model_.pixel(coder_, bit, inputs, near, other, nearest);
  }

  static uint32_t window(const BitRows& rows, int tile_x, int y) {
    uint32_t bits;
    std::memcpy(&bits, rows.at(tile_x - 1, y), sizeof bits);
    return bits;
  }

  Coder& coder_;
  Model& model_;
  const uint32_t tiles_x_, stride_, blocks_x_;
  WalkMemory& memory_;
  LightTiles light_;
  int row_ = 0;
  std::array<int, kSegment> mixed_{};
  size_t mixed_count_ = 0;
};

}  // namespace gnomon::protocol::context
