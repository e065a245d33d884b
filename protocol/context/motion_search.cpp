#include "protocol/context/motion_search.h"

#include <bit>

#include "protocol/context/tile_walk.h"

namespace gnomon::protocol::context {
namespace {

constexpr int kFirstStep = 4;
constexpr int kAround = 48, kAroundStep = 4;  // pixels
constexpr int kGoodFit = 0;                   // differing pixels of a tile

// What a motion costs beside another that is foreseen, in pixels that differ: some 1.2 for each bit that it takes.
int price(const Motion& motion, const Motion& predicted) {
  const auto bits = [](int number) {
    return number == 0 ? 1 : 1 + 2 * std::bit_width(static_cast<unsigned>(std::abs(number)));
  };
  return motion == predicted ? 0 : (bits(motion.dx - predicted.dx) + bits(motion.dy - predicted.dy)) * 2;
}

struct MixedTile {
  int x, y;  // of its first pixel
  uint64_t word;
};

class BlockSearch {
 public:
  BlockSearch(std::span<const MixedTile> tiles, const BitRows& reference, Motion predicted)
      : tiles_(tiles), reference_(reference), predicted_(predicted) {
    try_motion(predicted);
  }

  void try_motion(const Motion& motion) {
    if (std::abs(motion.dx) > kMostMotion || std::abs(motion.dy) > kMostMotion) return;
    int cost = price(motion, predicted_);
    for (const MixedTile& tile : tiles_) {
      cost += differing(tile, motion);
      if (cost >= least_) return;
    }
    least_ = cost;
    best_ = motion;
  }
  // Looks further around where nothing near fits well: the camera may have turned.
  void look_around() {
    if (least_ <= kGoodFit * static_cast<int>(tiles_.size())) return;
    for (int dy = -kAround; dy <= kAround; dy += kAroundStep)
      for (int dx = -kAround; dx <= kAround; dx += kAroundStep) try_motion({dx, dy});
  }
  void refine() {
    for (int step = kFirstStep; step > 0; step /= 2) {
      const Motion from = best_;
      for (int dy = -step; dy <= step; dy += step)
        for (int dx = -step; dx <= step; dx += step)
          if (dx != 0 || dy != 0) try_motion({from.dx + dx, from.dy + dy});
    }
  }
  Motion best() const { return best_; }

 private:
  int differing(const MixedTile& tile, Motion motion) const {
    const int x = std::clamp(tile.x + motion.dx, -24, reference_.width() + 8);
    const int y = std::clamp(tile.y + motion.dy, -24, reference_.height() + 8);
    uint64_t word = 0;
    for (int row = 0; row < 8; ++row) word |= uint64_t{reference_.window(x, y + row) & 0xff} << 8 * row;
    return std::popcount(word ^ tile.word);
  }

  std::span<const MixedTile> tiles_;
  const BitRows& reference_;
  Motion predicted_, best_;
  int least_ = 1 << 30;
};

}  // namespace

void find_motions(const TileGrid& grid, std::span<const PackedClass> classes, std::span<const uint64_t> words,
                  const BitRows& reference, uint32_t first, uint32_t end, std::span<Motion> motions) {
  const uint32_t blocks_x = (grid.tiles_x() + kBlock - 1) / kBlock;
  std::vector<MixedTile> tiles;
  std::vector<Motion> found(motions.size());  // what those without mixed tiles are foreseen to be, too
  for (uint32_t block_y = first; block_y < end; ++block_y) {
    for (uint32_t block_x = 0; block_x < blocks_x; ++block_x) {
      tiles.clear();
      for (uint32_t y = block_y * kBlock; y < std::min((block_y + 1) * kBlock, grid.tiles_y()); ++y)
        for (uint32_t x = block_x * kBlock; x < std::min((block_x + 1) * kBlock, grid.tiles_x()); ++x) {
          const size_t tile = size_t{y} * grid.tiles_x() + x;
          if (classes[tile] == PackedClass::mixed)
            tiles.push_back({static_cast<int>(x * 8), static_cast<int>(y * 8), words[tile]});
        }
      const size_t here = size_t{block_y} * blocks_x + block_x;
      const bool has_left = block_x > 0, has_above = block_y > first;
      const Motion left = has_left ? found[here - 1] : Motion{};
      const Motion above = has_above ? found[here - blocks_x] : left;
      const Motion right = has_above && block_x + 1 < blocks_x ? found[here - blocks_x + 1] : above;
      const Motion predicted = has_left && has_above ? median(left, above, right) : has_left ? left : above;
      found[here] = predicted;
      motions[here] = kAnyMotion;
      if (tiles.empty()) continue;
      BlockSearch search(tiles, reference, predicted);
      for (const Motion& motion : {left, above, right, Motion{}}) search.try_motion(motion);
      search.look_around();
      search.refine();
      motions[here] = found[here] = search.best();
    }
  }
}

}  // namespace gnomon::protocol::context
