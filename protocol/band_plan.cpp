#include "protocol/band_plan.h"

#include <algorithm>
#include <bit>
#include <numeric>

namespace gnomon::protocol {
namespace {

// Mixed tiles that are worth a band, some nine slices; and the most bands, as more would not find idle threads.
constexpr size_t kMixedOfABand = 1'536;
constexpr size_t kMostBands = 8;

// Mixed words among words [first, end).
uint32_t mixed_between(std::span<const uint32_t> classes, size_t first, size_t end) {
  constexpr uint32_t kLowBits = 0x55555555;
  uint32_t mixed = 0;
  for (size_t at = first; at < end;) {
    const size_t in_word = at % kClassesInWord;
    const size_t taken = std::min<size_t>(kClassesInWord - in_word, end - at);
    const uint32_t of_word = classes[at / kClassesInWord];
    const uint32_t is_mixed = of_word >> 1 & ~of_word & kLowBits;  // 2, PackedClass::mixed
    const uint32_t among = static_cast<uint32_t>((uint64_t{1} << 2 * taken) - 1) << 2 * in_word;
    mixed += static_cast<uint32_t>(std::popcount(is_mixed & among));
    at += taken;
  }
  return mixed;
}

}  // namespace

void BandPlan::plan(const PackedMaskView& frame) {
  static_assert(static_cast<int>(PackedClass::mixed) == 2);
  plan(frame.grid, [&](size_t first, size_t end) { return mixed_between(frame.classes, first, end); });
}

void BandPlan::plan(const TileMaskView& frame) {
  plan(frame.grid, [&](size_t first, size_t end) {
    const auto words = frame.words.subspan(first, end - first);
    return static_cast<uint32_t>(
        std::count_if(words.begin(), words.end(), [](uint64_t word) { return word + 1 > 1; }));
  });
}

template <class CountMixed>
void BandPlan::plan(const TileGrid& grid, CountMixed count_mixed) {
  tiles_y_ = grid.tiles_y();
  before_.resize(size_t{grid.planes} * tiles_y_);
  in_row_.assign(tiles_y_, 0);
  uint32_t before = 0;
  for (size_t i = 0; i < before_.size(); ++i) {
    const uint32_t mixed = count_mixed(i * grid.tiles_x(), (i + 1) * grid.tiles_x());
    before_[i] = before;
    before += mixed;
    in_row_[i % tiles_y_] += mixed;
  }
  divide(grid);
}

// Bands of about the same number of mixed tiles, at least a row of tiles each.
void BandPlan::divide(const TileGrid& grid) {
  rows_.clear();
  if (grid.word_count() == 0) return;
  const size_t all = std::accumulate(in_row_.begin(), in_row_.end(), size_t{0});
  const size_t bands = std::clamp<size_t>(all / kMixedOfABand, 1, std::min<size_t>(kMostBands, tiles_y_));
  size_t before = 0;  // mixed tiles of rows before the one looked at
  TileRows band;
  for (uint32_t row = 0; row < tiles_y_; ++row) {
    before += in_row_[row];
    ++band.count;
    if (rows_.size() + 1 == bands || before * bands < all * (rows_.size() + 1)) continue;
    rows_.push_back(band);
    band = {row + 1, 0};
  }
  if (band.count > 0) rows_.push_back(band);
}

}  // namespace gnomon::protocol
