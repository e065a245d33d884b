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

inline constexpr uint32_t kBlock = 8;  // tiles; side of a block, which has one motion

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
    code_classes(x0, x1);
    for (int y = 0; y < 8; ++y)
      for (size_t i = 0; i < mixed_count_; ++i) code_pixels(mixed_[i], y);
    for (size_t i = 0; i < mixed_count_; ++i) word(mixed_[i].x) = memory_.rows.get(mixed_[i].x, row_);
  }

 private:
  static constexpr bool kReferenced = Model::kReferenced;

  uint64_t& word(int x) { return light_.words[static_cast<size_t>(row_) * tiles_x_ + static_cast<size_t>(x)]; }
  uint8_t* class_at(int x, int row) const {
    return &memory_.classes[static_cast<size_t>(row + 2) * stride_ + 2] + x;
  }

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

  void code_classes(int x0, int x1) {
    for (int x = x0; x < x1;) {
      const uint32_t quiet = quiet_tiles(x, x1);
      if (quiet > 0) {
        x += code_quiet(x, quiet);
      } else {
        take_class(x, model_.tile(coder_, source_class(x), surroundings(x)));
        ++x;
      }
    }
  }

  // The number of tiles from `x` on that have even surroundings, if all before the last are as these.
  uint32_t quiet_tiles(int x, int x1) const {
    const uint8_t around = class_at(x, row_)[-1];
    const uint8_t* above = class_at(x, row_ - 1);
    if (around >= kMixed || above[-1] != around || above[0] != around) return 0;
    int end = x;
    while (end < x1 && above[end - x + 1] == around && (!kReferenced || reference_is(end, around == kLit))) ++end;
    return static_cast<uint32_t>(end - x);
  }
  // Codes tiles up to the first that is not as its surroundings, at most `length`; returns their number.
  int code_quiet(int x, uint32_t length) {
    const uint8_t around = class_at(x, row_)[-1];
    uint32_t kept = 0;
    if constexpr (!Coder::kDecodes) {
      const auto as_around = [&](PackedClass c) { return c == PackedClass::free || c == PackedClass{around}; };
      while (kept < length && as_around(source_class(x + static_cast<int>(kept)))) ++kept;
    }
    kept = model_.quiet_tiles(coder_, kept, around == kLit, length);
    for (uint32_t i = 0; i < kept; ++i) take_class(x + static_cast<int>(i), around);
    if (kept == length) return static_cast<int>(length);
    const int odd = x + static_cast<int>(kept);
    take_class(odd, model_.odd_tile(coder_, source_class(odd), around == kLit));
    return static_cast<int>(kept) + 1;
  }
  PackedClass source_class(int x) const {
    if constexpr (Coder::kDecodes) return {};
    return light_.classes[static_cast<size_t>(row_) * tiles_x_ + static_cast<size_t>(x)];
  }

  void take_class(int x, uint8_t coded) {
    *class_at(x, row_) = coded;
    if (coded == kMixed) {
      mixed_[mixed_count_++] = {x};
      return;
    }
    const uint64_t uniform = coded == kLit ? ~uint64_t{0} : 0;
    word(x) = uniform;
    if (uniform != 0) memory_.rows.put(x, row_, uniform);
  }

  TileSurroundings<kReferenced> surroundings(int x) const {
    const uint8_t* here = class_at(x, row_);
    const uint8_t* above = class_at(x, row_ - 1);
    const uint8_t* last = memory_.rows.at(x, row_ * 8 - 1);
    TileSurroundings<kReferenced> around{.west = here[-1],
                                         .north = above[0],
                                         .north_east = above[1],
                                         .north_west = above[-1],
                                         .west2 = here[-2],
                                         .north2 = *class_at(x, row_ - 2),
                                         .north_east2 = above[2],
                                         .north_west2 = above[-2],
                                         .above = {last[-1], last[0], last[1]},
                                         .above2 = *memory_.rows.at(x, row_ * 8 - 2)};
    if constexpr (kReferenced) {
      const Place at = in_reference(x);
      for (int y = 0; y < 12; ++y)
        around.reference[static_cast<size_t>(y)] = light_.reference->window(at.x - 2, at.y + y - 2) & 0xfff;
    }
    return around;
  }

  // Whether the reference has that value in all pixels of a tile's counterpart and in the two around it.
  bool reference_is(int x, bool lit) const {
    const Place at = in_reference(x);
    return light_.reference->is_even(at.x - 2, at.y - 2, 12, lit);
  }

  // A tile of the segment whose pixels are coded, and what its rows so far have.
  struct MixedTile {
    int x = 0;
    uint8_t any = 0, all = 0xff;
  };

  // Codes one pixel row of a mixed tile.
  void code_pixels(MixedTile& tile, int y) {
    const int line = row_ * 8 + y;
    const BitRows& rows = memory_.rows;
    RowWindows<kReferenced> windows{.now = rows.at(tile.x, line)[-1],
                                    .above1 = window(rows, tile.x, line - 1),
                                    .above2 = window(rows, tile.x, line - 2),
                                    .above3 = window(rows, tile.x, line - 3),
                                    .y = static_cast<uint32_t>(y),
                                    .right = *class_at(tile.x + 1, row_),
                                    .all_lit = tile.all == 0xff,
                                    .all_dark = tile.any == 0};
    if constexpr (kReferenced) {
      const Place at = in_reference(tile.x);
      for (int i = 0; i < 5; ++i)
        windows.reference[static_cast<size_t>(i)] = light_.reference->window(at.x - 8, at.y + y + i - 2);
    }
    uint32_t source = 0;
    if constexpr (!Coder::kDecodes) source = static_cast<uint32_t>(word(tile.x) >> 8 * y) & 0xff;
    const uint32_t even = windows.even();
    for (int at = 0; at < 8;) {
      const int run = windows.run(at, even);
      if (run > 0) {
        at += code_run(windows, at, run, source);
      } else {
        windows.now |= uint32_t{model_.pixel(coder_, (source >> at & 1) != 0, windows, at)} << (8 + at);
        ++at;
      }
    }
    const auto coded = static_cast<uint8_t>(windows.now >> 8);
    *memory_.rows.at(tile.x, line) = coded;
    tile.any |= coded;
    tile.all &= coded;
  }

  // Codes a run up to the first pixel that is not as those before it, at most `length`; returns their number.
  int code_run(RowWindows<kReferenced>& windows, int at, int length, uint32_t source) {
    const bool lit = windows.last(at);
    int kept = 0;
    if constexpr (!Coder::kDecodes)
      kept = std::min(length, std::countr_zero((lit ? ~source : source) >> at | 1u << length));
    kept = model_.run(coder_, kept, windows, at, length);
    const uint32_t as_before = (1u << kept) - 1, odd = kept < length ? 1u << kept : 0;
    windows.now |= (lit ? as_before : odd) << (8 + at);
    return std::min(kept + 1, length);
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
  std::array<MixedTile, kSegment> mixed_{};
  size_t mixed_count_ = 0;
};

}  // namespace gnomon::protocol::context
