#include "gpu/tracers/light_buffer/subdivide.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "gpu/tracers/light_buffer/entry.h"

namespace gnomon::gpu::light_buffer {
namespace {

using Met = std::vector<const Footprint*>;

class Builder {
 public:
  Builder(const Face& face, const Detail& detail, double surface, Piece& out)
      : face_(face), detail_(detail), surface_(surface), out_(out) {}

  void build(uint32_t level, uint32_t i, uint32_t j, Met& met) {
    if (level == kTopLevel) deepest_ = kTopLevel;
    deepest_ = std::max(deepest_, level);
    const Rect rect = face_.square(level, i, j);
    Leaf leaf;
    drop_hidden(leaf, rect, met);
    out_.work += met.size() + 1;
    // A square with a long list is mostly divided, and then needs no near plane, which looks at every footprint.
    const bool is_long = met.size() > kLong;
    const Linear near = is_long ? Linear(0.0) : set_near_plane(leaf, rect, met);
    const bool fine = met.size() <= 1 || level >= detail_.finest_level ||
                      (is_long ? rough_cost(rect, met) : cost(rect, met, near)) <=
                          detail_.cost_per_byte * bytes_to_divide(level, met);
    if (fine || !divide(level, i, j, met)) {
      if (is_long) set_near_plane(leaf, rect, met);
      place(level, i, j, add_leaf(leaf, level, i, j, met));
    }
    if (level == kTopLevel) close_cell(i, j);
  }

 private:
  void drop_hidden(Leaf& leaf, const Rect& rect, Met& met) {
    const Footprint* cover = find_cover(met, rect);
    if (cover != nullptr && face_.plane(cover->cover, -1.0, leaf.cover_plane)) {
      std::erase_if(met, [&](const Footprint* f) { return hidden(*f, *cover, rect); });
    }
  }

  // Leaves the nearness of each footprint in `nearness_`.
  Linear set_near_plane(Leaf& leaf, const Rect& rect, const Met& met) {
    Linear plane(0, 0, 1e30);
    nearness_.clear();
    if (met.empty()) return plane;
    for (const Footprint* f : met) nearness_.push_back(nearest_in(*f, rect));
    if (!fit_near_plane(met, nearness_, rect, plane) ||
        (!face_.plane(plane, 1.0, leaf.near_plane) &&
         !face_.plane(Linear(0, 0, std::ranges::max(nearness_)), 1.0, leaf.near_plane))) {
      // There is no near plane: this one has no point in front of it at any depth that a float can hold.
      leaf.near_plane = glm::vec3(face_.depth_axis * 1e30);
    }
    return plane;
  }

  // What a query costs that asks this leaf, times the share of the scene's surface that asks it. It assumes that the
  // surfaces that are seen are mostly those that cast the shadows: each footprint asks for as much of its triangle as
  // lies here. It costs nothing where that lies on the near plane, else a start, a step for each footprint before it,
  // and a test for each of these whose box holds it. Steps are the unit.
  double cost(const Rect& rect, const Met& met, const Linear& near) {
    const double whole = area(rect);
    asking_.clear();
    for (size_t k = 0; k < met.size(); ++k) {
      const Footprint& f = *met[k];
      const Rect part = common(rect, f.box);
      asking_.push_back({nearness_[k], kStep + kTest * std::min(1.0, area(part) / whole),
                         asks(f, part) * walking(f, part, near)});
    }
    std::sort(asking_.begin(), asking_.end(),
              [](const Asking& a, const Asking& b) { return a.nearness > b.nearness; });
    double price = kStart, sum = 0;
    for (const Asking& one : asking_) {
      price += one.price;
      sum += one.weight * waited_for(price);
    }
    return sum / surface_ + elsewhere(rect, price);
  }

  // Of a list so long that more takes longer than it is worth.
  double rough_cost(const Rect& rect, const Met& met) const {
    const double price = kStart + kStep * static_cast<double>(met.size());
    double sum = 0;
    for (const Footprint* f : met) sum += asks(*f, common(rect, f->box));
    return sum * waited_for(price) / surface_ + elsewhere(rect, price);
  }

  static double area(const Rect& r) { return std::max(0.0, r.u1 - r.u0) * std::max(0.0, r.v1 - r.v0); }

  // What surfaces ask that are no occluders of this face: a part of all, evenly over the directions. Without it nothing
  // would divide a long list of triangles too small to matter as surfaces.
  double elsewhere(const Rect& rect, double price) const {
    constexpr double kPart = 0.3, kFaces = 6.0;
    return kPart * area(rect) / (kFaces * face_.size * face_.size) * waited_for(price);
  }

  // Lanes wait for the one with the longest walk, and a frame for its last tile: a long walk costs more than its steps.
  static double waited_for(double price) {
    constexpr double kUsual = 16.0;
    return price * (1.0 + price / kUsual);
  }

  // The area of the triangle that asks here, if `part` of its picture lies here. Of one that turns its back on the
  // light only what belongs to open meshes asks.
  static double asks(const Footprint& f, const Rect& part) {
    constexpr double kBacks = 0.5;
    const double whole = area(f.box);
    if (!std::isfinite(whole) || whole <= 0.0) return 0.0;
    return (f.faces_light ? 1.0 : kBacks) * f.area * area(part) / whole;
  }

  // The share of a footprint's part that lies behind the near plane, from a few places of it.
  static double walking(const Footprint& f, const Rect& part, const Linear& near) {
    if (!f.bounded) return 1.0;
    constexpr std::array<glm::dvec2, 4> kPlaces = {{{0.25, 0.15}, {0.85, 0.25}, {0.15, 0.75}, {0.75, 0.85}}};
    double behind = 0;
    for (const glm::dvec2& p : kPlaces) {
      const double u = part.u0 + p.x * (part.u1 - part.u0), v = part.v0 + p.y * (part.v1 - part.v0);
      const double bound = at(near, u, v);
      behind += at(f.nearest, u, v) < bound - 1e-4 * std::abs(bound) ? 0.25 : 0.0;
    }
    return behind;
  }

  // What the leaf takes if it is divided: leaves, words of the grid, and the entries that more than one of them needs.
  double bytes_to_divide(uint32_t level, const Met& met) const {
    const double lists = 128.0 + 6.0 * static_cast<double>(met.size());
    return level < deepest_ || level < kTopLevel ? lists : lists + block_bytes(level + 1) - block_bytes(deepest_);
  }

  // Of a cell whose finest leaves are of this level.
  static double block_bytes(uint32_t level) {
    return sizeof(uint32_t) * power_of_two(2 * static_cast<int>(level - kTopLevel));
  }

  // Divides the square; returns false if that would not shorten the lists.
  bool divide(uint32_t level, uint32_t i, uint32_t j, const Met& met) {
    std::array<Met, 4>& child = children_[level];
    std::array<Rect, 4> rects;
    for (uint32_t c = 0; c < 4; ++c) {
      child[c].clear();
      rects[c] = face_.square(level + 1, 2 * i + (c & 1), 2 * j + (c >> 1));
    }
    for (const Footprint* f : met) {
      for (uint32_t c = 0; c < 4; ++c)
        if (meets(*f, rects[c])) child[c].push_back(f);
    }
    const size_t total = child[0].size() + child[1].size() + child[2].size() + child[3].size();
    if (level >= kTopLevel && 10 * total > 36 * met.size() && met.size() < 64) return false;
    for (uint32_t c = 0; c < 4; ++c) build(level + 1, 2 * i + (c & 1), 2 * j + (c >> 1), child[c]);
    return true;
  }

  // set_near_plane has seen these footprints last.
  uint32_t add_leaf(Leaf leaf, uint32_t level, uint32_t i, uint32_t j, const Met& met) {
    if (met.empty() && leaf.cover_plane == glm::vec3(0.0f)) return 0;
    leaf.first = static_cast<uint32_t>(out_.entries.size());
    const LeafEntries entries(face_, level, i, j);
    for (size_t k = 0; k < met.size(); ++k) {
      const auto entry = entries.entry(*met[k], nearness_[k]);
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
  static constexpr double kStart = 3.0, kStep = 1.0, kTest = 3.0;  // of what a query costs
  static constexpr size_t kLong = 256;                             // of a list: beyond it, costs are rough

  // A footprint as cost() sees it.
  struct Asking {
    double nearness, price, weight;
  };

  const Face& face_;
  const Detail& detail_;
  const double surface_;
  Piece& out_;
  // Kept for their memory from square to square.
  std::vector<Asking> asking_;
  std::array<std::array<Met, 4>, kFinestLevel> children_;  // of the open square of each level
  std::vector<double> nearness_;                           // of the footprints of the last near plane
  uint32_t deepest_ = kTopLevel;                           // finest level of the open cell's leaves
  std::array<uint32_t, kPatchSide * kPatchSide> patch_{};  // its leaves, at the finest level
};

}  // namespace

Piece build_piece(const Face& face, const Detail& detail, double surface, uint32_t i, uint32_t j, Met met) {
  Piece piece;
  piece.cells.resize(size_t{kRootCells} * kRootCells);
  piece.leaves.resize(1);
  const Rect rect = face.square(kRootLevel, i, j);
  std::erase_if(met, [&](const Footprint* f) { return !meets(*f, rect); });
  Builder(face, detail, surface, piece).build(kRootLevel, i, j, met);
  return piece;
}

}  // namespace gnomon::gpu::light_buffer
