#include "gpu/tracers/light_buffer/subdivide.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace gnomon::gpu::light_buffer {
namespace {

using Met = std::vector<const Footprint*>;

class Builder {
 public:
  Builder(const Face& face, const Detail& detail, Piece& out) : face_(face), detail_(detail), out_(out) {}

  void build(uint32_t level, uint32_t i, uint32_t j, Met& met) {
    if (level == kTopLevel) deepest_ = kTopLevel;
    deepest_ = std::max(deepest_, level);
    const Rect rect = face_.square(level, i, j);
    Leaf leaf;
    drop_hidden(leaf, rect, met);
    const Linear near = set_near_plane(leaf, rect, met);
    const bool fine = met.size() <= 1 || level >= detail_.finest_level || walk(rect, met, near) <= patience(level);
    if (fine || !divide(level, i, j, met)) place(level, i, j, add_leaf(leaf, level, i, j, met));
    if (level == kTopLevel) close_cell(i, j);
  }

 private:
  void drop_hidden(Leaf& leaf, const Rect& rect, Met& met) {
    const Footprint* cover = find_cover(met, rect);
    if (cover != nullptr && face_.plane(cover->cover, -1.0, leaf.cover_plane)) {
      std::erase_if(met, [&](const Footprint* f) { return hidden(*f, *cover, rect); });
    }
  }

  Linear set_near_plane(Leaf& leaf, const Rect& rect, const Met& met) {
    Linear nearness(0, 0, 1e30);
    if (met.empty()) return nearness;
    if (!fit_near_plane(met, rect, nearness) ||
        (!face_.plane(nearness, 1.0, leaf.near_plane) &&
         !face_.plane(Linear(0, 0, nearest_of_all(rect, met)), 1.0, leaf.near_plane))) {
      // There is no near plane: this one has no point in front of it at any depth that a float can hold.
      leaf.near_plane = glm::vec3(face_.depth_axis * 1e30);
    }
    return nearness;
  }

  // Fine leaves are many and few pixels see each of them, so that only long lists justify dividing them further.
  double patience(uint32_t level) const {
    return level <= detail_.usual_level
               ? detail_.longest_walk
               : std::ldexp(detail_.longest_walk, static_cast<int>(level - detail_.usual_level));
  }

  // An estimate of the triangles that are tested for a point on one of the footprints, on average over the footprints:
  // none if it lies on the near plane, else those in front of it. It assumes that the visible surfaces of a scene are
  // mostly those that cast its shadows.
  static double walk(const Rect& rect, const Met& met, const Linear& near) {
    size_t walking = 0;
    for (const Footprint* f : met) {
      const double u = std::clamp(0.5 * (rect.u0 + rect.u1), f->box.u0, f->box.u1);
      const double v = std::clamp(0.5 * (rect.v0 + rect.v1), f->box.v0, f->box.v1);
      const double bound = at(near, u, v);
      if (!f->bounded || at(f->nearest, u, v) < bound - 0.003 * std::abs(bound)) ++walking;
    }
    return 0.5 * static_cast<double>(walking);
  }

  static double nearest_of_all(const Rect& rect, const Met& met) {
    double nearest = nearest_in(*met.front(), rect);
    for (const Footprint* f : met) nearest = std::max(nearest, nearest_in(*f, rect));
    return nearest;
  }

  // Divides the square; returns false if that would not shorten the lists.
  bool divide(uint32_t level, uint32_t i, uint32_t j, const Met& met) {
    std::array<Met, 4> child;
    size_t total = 0;
    for (uint32_t c = 0; c < 4; ++c) {
      const Rect rect = face_.square(level + 1, 2 * i + (c & 1), 2 * j + (c >> 1));
      for (const Footprint* f : met) {
        if (meets(*f, rect)) child[c].push_back(f);
      }
      total += child[c].size();
    }
    if (10 * total > 36 * met.size() && met.size() < 64) return false;
    for (uint32_t c = 0; c < 4; ++c) build(level + 1, 2 * i + (c & 1), 2 * j + (c >> 1), child[c]);
    return true;
  }

  uint32_t add_leaf(Leaf leaf, uint32_t level, uint32_t i, uint32_t j, const Met& met) {
    if (met.empty() && leaf.cover_plane == glm::vec3(0.0f)) return 0;
    leaf.first = static_cast<uint32_t>(out_.entries.size());
    leaf.count = static_cast<uint32_t>(met.size()) | level << kCountBits;
    const Rect rect = face_.square(level, i, j);
    for (const Footprint* f : met) {
      out_.entries.push_back(
          {face_.box_in_square(f->box, level, i, j), face_.reciprocal_depth(nearest_in(*f, rect)), f->triangle});
    }
    std::sort(out_.entries.begin() + leaf.first, out_.entries.end(), [](const ListEntry& a, const ListEntry& b) {
      return a.reciprocal_depth != b.reciprocal_depth ? a.reciprocal_depth > b.reciprocal_depth
                                                      : a.triangle < b.triangle;
    });
    out_.leaves.push_back(leaf);
    return static_cast<uint32_t>(out_.leaves.size()) - 1;
  }

  // Writes the leaf to all cells that it contains, or into the open cell's patch if it is finer than a cell.
  void place(uint32_t level, uint32_t i, uint32_t j, uint32_t leaf) {
    if (level < kTopLevel) {
      const uint32_t word = add_block(0, &leaf);
      const uint32_t side = 1u << (kTopLevel - level);
      fill(out_.cells.data(), kRootCells, (i * side) % kRootCells, (j * side) % kRootCells, side, word);
    } else {
      const uint32_t side = 1u << (kFinestLevel - level);
      fill(patch_.data(), kPatchSide, (i * side) % kPatchSide, (j * side) % kPatchSide, side, leaf);
    }
  }

  static void fill(uint32_t* grid, uint32_t grid_side, uint32_t i, uint32_t j, uint32_t side, uint32_t value) {
    for (uint32_t y = j; y < j + side; ++y) std::fill_n(grid + y * grid_side + i, side, value);
  }

  // Writes the patch as the cell's block, at the coarsest level that holds its leaves.
  void close_cell(uint32_t i, uint32_t j) {
    const uint32_t bits = deepest_ - kTopLevel;
    const uint32_t step = kPatchSide >> bits;
    std::array<uint32_t, kPatchSide * kPatchSide> block;
    size_t n = 0;
    for (uint32_t y = 0; y < kPatchSide; y += step) {
      for (uint32_t x = 0; x < kPatchSide; x += step) block[n++] = patch_[y * kPatchSide + x];
    }
    out_.cells[(j % kRootCells) * kRootCells + i % kRootCells] = add_block(bits, block.data());
  }

  uint32_t add_block(uint32_t bits, const uint32_t* leaves) {
    const uint32_t start = static_cast<uint32_t>(out_.blocks.size());
    out_.blocks.insert(out_.blocks.end(), leaves, leaves + (size_t{1} << (2 * bits)));
    return start << kDepthBits | bits;
  }

  static constexpr uint32_t kPatchSide = 1u << kBlockBits;

  const Face& face_;
  const Detail& detail_;
  Piece& out_;
  uint32_t deepest_ = kTopLevel;                           // finest level of the open cell's leaves
  std::array<uint32_t, kPatchSide * kPatchSide> patch_{};  // its leaves, at the finest level
};

}  // namespace

Piece build_piece(const Face& face, const Detail& detail, uint32_t i, uint32_t j, Met met) {
  Piece piece;
  piece.cells.resize(size_t{kRootCells} * kRootCells);
  piece.leaves.resize(1);
  const Rect rect = face.square(kRootLevel, i, j);
  std::erase_if(met, [&](const Footprint* f) { return !meets(*f, rect); });
  Builder(face, detail, piece).build(kRootLevel, i, j, met);
  return piece;
}

}  // namespace gnomon::gpu::light_buffer
