#include "gpu/tracers/light_buffer/subdivide.h"

#include <algorithm>
#include <array>

#include "gpu/tracers/light_buffer/entry.h"
#include "gpu/tracers/light_buffer/squares.h"

namespace gnomon::gpu::light_buffer {
namespace {

class Builder {
 public:
  Builder(const Face& face, const Detail& detail, double surface, Piece& out)
      : squares_(face, surface), detail_(detail), out_(out) {}

  void build(uint32_t level, uint32_t i, uint32_t j, Met& met) {
    if (level == kTopLevel) deepest_ = kTopLevel;
    deepest_ = std::max(deepest_, level);
    const Rect rect = squares_.face().square(level, i, j);
    Leaf leaf;
    squares_.drop_hidden(leaf, rect, met);
    out_.work += met.size() + 1;
    const bool is_long = Squares::is_long(met);
    const Linear near = is_long ? Linear(0.0) : squares_.set_near_plane(leaf, rect, met);
    const bool fine = met.size() <= 1 || level >= detail_.finest_level ||
                      squares_.cost(rect, met, near) <=
                          detail_.cost_per_byte * Squares::bytes_to_divide(level, deepest_, met.size());
    std::array<Met, 4>* parts = fine ? nullptr : squares_.parts(level, i, j, met);
    if (parts != nullptr) {
      for (uint32_t c = 0; c < 4; ++c) build(level + 1, 2 * i + (c & 1), 2 * j + (c >> 1), (*parts)[c]);
    } else {
      if (is_long) squares_.set_near_plane(leaf, rect, met);
      place(level, i, j, add_leaf(leaf, level, i, j, met));
    }
    if (level == kTopLevel) close_cell(i, j);
  }

 private:
  // set_near_plane has seen these footprints last.
  uint32_t add_leaf(Leaf leaf, uint32_t level, uint32_t i, uint32_t j, const Met& met) {
    if (met.empty() && leaf.cover_plane == glm::vec3(0.0f)) return 0;
    leaf.first = static_cast<uint32_t>(out_.entries.size());
    const LeafEntries entries(squares_.face(), level, i, j);
    for (size_t k = 0; k < met.size(); ++k) {
      const auto entry = entries.entry(*met[k], squares_.nearness()[k]);
      if (entry) out_.entries.push_back(*entry);
    }
    const auto count = static_cast<uint32_t>(out_.entries.size()) - leaf.first;
    if (count == 0 && leaf.cover_plane == glm::vec3(0.0f)) return 0;
    leaf.count = count | level << kCountBits;
    std::sort(out_.entries.begin() + leaf.first, out_.entries.end(), [](const ListEntry& a, const ListEntry& b) {
      return a.depth_and_low != b.depth_and_low ? a.depth_and_low > b.depth_and_low : a.triangle < b.triangle;
    });
    out_.leaves.push_back(leaf);
    return static_cast<uint32_t>(out_.leaves.size()) - 1;
  }

  // Writes the leaf to all cells that it contains, or notes it as one of the open cell's if it is no larger.
  void place(uint32_t level, uint32_t i, uint32_t j, uint32_t leaf) {
    if (level < kTopLevel) {
      const uint32_t word = add_block(0, &leaf);
      const uint32_t side = 1u << (kTopLevel - level);
      fill(out_.cells.data(), kRootCells, (i * side) % kRootCells, (j * side) % kRootCells, side, word);
    } else {
      open_.push_back({level, i, j, leaf});
    }
  }

  static void fill(uint32_t* grid, uint32_t grid_side, uint32_t i, uint32_t j, uint32_t side, uint32_t value) {
    for (uint32_t y = j; y < j + side; ++y) std::fill_n(grid + y * grid_side + i, side, value);
  }

  // Writes the cell's block, at the coarsest level that holds its leaves.
  void close_cell(uint32_t i, uint32_t j) {
    const uint32_t bits = deepest_ - kTopLevel, block_side = 1u << bits;
    block_.resize(size_t{block_side} * block_side);
    for (const PlacedLeaf& p : open_) {
      const uint32_t side = 1u << (deepest_ - p.level);
      fill(block_.data(), block_side, (p.i * side) % block_side, (p.j * side) % block_side, side, p.leaf);
    }
    open_.clear();
    out_.cells[(j % kRootCells) * kRootCells + i % kRootCells] = add_block(bits, block_.data());
  }

  uint32_t add_block(uint32_t bits, const uint32_t* leaves) {
    const uint32_t start = static_cast<uint32_t>(out_.blocks.size());
    out_.blocks.insert(out_.blocks.end(), leaves, leaves + (size_t{1} << (2 * bits)));
    return start << kDepthBits | bits;
  }

  struct PlacedLeaf {
    uint32_t level, i, j, leaf;
  };

  Squares squares_;
  const Detail& detail_;
  Piece& out_;
  uint32_t deepest_ = kTopLevel;  // finest level of the open cell's leaves
  std::vector<PlacedLeaf> open_;  // these leaves
  std::vector<uint32_t> block_;
};

}  // namespace

Piece build_piece(const Face& face, const Detail& detail, double surface, uint32_t i, uint32_t j, Met met) {
  thread_local Piece piece;  // what lasts takes no more memory than it needs
  piece.cells.assign(size_t{kRootCells} * kRootCells, 0);
  piece.blocks.clear();
  piece.leaves.assign(1, Leaf{});
  piece.entries.clear();
  piece.work = 0;
  const Rect rect = face.square(kRootLevel, i, j);
  std::erase_if(met, [&](const Footprint* f) { return !meets(*f, rect); });
  Builder(face, detail, surface, piece).build(kRootLevel, i, j, met);
  return piece;
}

}  // namespace gnomon::gpu::light_buffer
