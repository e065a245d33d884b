#include "protocol/context/motion_search.h"

#include <array>
#include <bit>

namespace gnomon::protocol::context {
namespace {

constexpr float kAlongStep = 3;               // pixels between the candidates of successive distances
constexpr float kNearest = 0.25f;             // metres
constexpr int kMostTries = 64;                // distances tried at most
constexpr int kAround = 24, kAroundStep = 4;  // pixels; without a camera
constexpr int kFirstStep = 2;

// The price of coding a motion when another is predicted, in pixels that differ: 2 for each bit that it roughly takes.
int price(const Motion& motion, const Motion& predicted) {
  const auto bits = [](int number) {
    return number == 0 ? 1 : 1 + 2 * std::bit_width(static_cast<unsigned>(std::abs(number)));
  };
  return motion == predicted ? 0 : (bits(motion.dx - predicted.dx) + bits(motion.dy - predicted.dy)) * 2;
}

// The number of bits that are 1. std::popcount is a call into a library where the processor is not known to have the
// instruction, which took as long as the rest of the search.
int count_ones(uint64_t bits) {
  bits -= bits >> 1 & 0x5555555555555555;
  bits = (bits & 0x3333333333333333) + (bits >> 2 & 0x3333333333333333);
  bits = (bits + (bits >> 4)) & 0x0f0f0f0f0f0f0f0f;
  return static_cast<int>(bits * 0x0101010101010101 >> 56);
}

// The mixed tiles of a block, as rows of 64 pixels.
struct BlockPixels {
  static constexpr int kSide = int{kBlock} * 8;

  int x = 0, y = 0;                      // of its first pixel
  std::array<uint64_t, kSide> rows;      // defined in rows of tiles with mixed ones
  std::array<uint64_t, kBlock> mixed{};  // pixel columns, for each row of tiles
  int tiles = 0;

  void add(uint32_t tile_x, uint32_t tile_y, uint64_t word) {
    if (mixed[tile_y] == 0) std::fill_n(&rows[tile_y * 8], 8, 0);
    mixed[tile_y] |= uint64_t{0xff} << tile_x * 8;
    for (uint32_t row = 0; row < 8; ++row) rows[tile_y * 8 + row] |= (word >> 8 * row & 0xff) << tile_x * 8;
    ++tiles;
  }
};

class BlockSearch {
 public:
  BlockSearch(const BlockPixels& block, const BitRows& reference, Motion predicted)
      : block_(block), reference_(reference), predicted_(predicted) {
    try_motion(predicted);
  }

  void try_motion(const Motion& motion) {
    if (std::abs(motion.dx) > kMostMotion || std::abs(motion.dy) > kMostMotion) return;
    int cost = price(motion, predicted_);
    for (size_t row = 0; row < kBlock && cost < least_; ++row)
      if (block_.mixed[row] != 0) cost += differing(row, motion);
    if (cost >= least_) return;
    least_ = cost;
    best_ = motion;
  }
  // As the camera moves, a surface that stands still moves along a line, the further the nearer it is.
  void look_along(const CameraMotion& camera) {
    const float x = static_cast<float>(block_.x) + BlockPixels::kSide / 2,
                y = static_cast<float>(block_.y) + BlockPixels::kSide / 2;
    const auto far = camera.at(x, y, 0);
    if (far) try_motion(*far);
    const float step = camera.nearness_step(x, y, kAlongStep);
    for (int i = 1; i <= kMostTries && step * static_cast<float>(i) < 1 / kNearest; ++i) {
      const auto motion = camera.at(x, y, step * static_cast<float>(i));
      if (motion) try_motion(*motion);
    }
  }
  void look_around() {
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
  // The number of pixels that differ in a row of tiles.
  int differing(size_t row, Motion motion) const {
    const int x = block_.x + motion.dx, top = block_.y + static_cast<int>(row) * 8;
    const int y = std::clamp(top + motion.dy, -24, reference_.height() + 8);
    int count = 0;
    if (x < -24 || x + BlockPixels::kSide - 8 > reference_.width() + 8) {
      for (int tile = 0; tile < int{kBlock}; ++tile)
        if ((block_.mixed[row] >> 8 * tile & 1) != 0) count += differing_tile(row, tile, y, motion.dx);
      return count;
    }
    for (int line = 0; line < 8; ++line)
      count += count_ones((reference_.wide_window(x, y + line) ^ block_.rows[row * 8 + static_cast<size_t>(line)]) &
                          block_.mixed[row]);
    return count;
  }
  // The same of one tile, whose place is clamped near the picture, as a walk clamps it.
  int differing_tile(size_t row, int tile, int y, int dx) const {
    const int x = std::clamp(block_.x + tile * 8 + dx, -24, reference_.width() + 8);
    int count = 0;
    for (int line = 0; line < 8; ++line)
      count += count_ones((reference_.window(x, y + line) ^
                           static_cast<uint32_t>(block_.rows[row * 8 + static_cast<size_t>(line)] >> 8 * tile)) &
                          0xff);
    return count;
  }

  const BlockPixels& block_;
  const BitRows& reference_;
  Motion predicted_, best_;
  int least_ = 1 << 30;
};

}  // namespace

void find_motions(const TileGrid& grid, const LightTiles& tiles, const CameraMotion* camera, const BlockRows& rows,
                  std::span<Motion> motions) {
  const uint32_t blocks_x = (grid.tiles_x() + kBlock - 1) / kBlock;
  std::vector<Motion> found(motions.size());  // blocks without mixed tiles have the predicted one
  for (uint32_t block_y = rows.first; block_y < rows.end; ++block_y) {
    for (uint32_t block_x = 0; block_x < blocks_x; ++block_x) {
      BlockPixels block;
      block.x = static_cast<int>(block_x) * BlockPixels::kSide;
      block.y = static_cast<int>(block_y) * BlockPixels::kSide;
      for (uint32_t y = block_y * kBlock; y < std::min((block_y + 1) * kBlock, grid.tiles_y()); ++y)
        for (uint32_t x = block_x * kBlock; x < std::min((block_x + 1) * kBlock, grid.tiles_x()); ++x) {
          const size_t tile = size_t{y} * grid.tiles_x() + x;
          if (tiles.classes[tile] == PackedClass::mixed) block.add(x % kBlock, y % kBlock, tiles.words[tile]);
        }
      const size_t here = size_t{block_y} * blocks_x + block_x;
      const bool has_left = block_x > 0, has_above = block_y > rows.first;
      const Motion left = has_left ? found[here - 1] : Motion{};
      const Motion above = has_above ? found[here - blocks_x] : left;
      const Motion right = has_above && block_x + 1 < blocks_x ? found[here - blocks_x + 1] : above;
      const Motion predicted = has_left && has_above ? median(left, above, right) : has_left ? left : above;
      found[here] = predicted;
      motions[here] = kAnyMotion;
      if (block.tiles == 0) continue;
      BlockSearch search(block, *tiles.reference, predicted);
      for (const Motion& motion : {left, above, right, Motion{}}) search.try_motion(motion);
      if (camera) {
        search.look_along(*camera);
      } else {
        search.look_around();
      }
      search.refine();
      motions[here] = found[here] = search.best();
    }
  }
}

}  // namespace gnomon::protocol::context
