// Divides a frame of tiles_lz4 into bands, rows of tiles of all its lights, that threads may encode independently.
#pragma once

#include <cstdint>
#include <vector>

#include "common/packed_mask.h"
#include "common/tile_mask.h"

namespace gnomon::protocol {

// The division depends on the frame alone, not on the number of threads. A frame with few mixed tiles is one band, as each
// band's last slice is only partly filled. One object may plan many frames: it reuses its memory.
class BandPlan {
 public:
  void plan(const PackedMaskView& frame);
  void plan(const TileMaskView& frame);

  size_t band_count() const { return rows_.size(); }
  TileRows rows(size_t band) const { return rows_[band]; }
  // Mixed words of `plane` in the rows of tiles before `row`, and of all planes before it: an index into
  // PackedMaskView::mixed.
  size_t mixed_before(uint32_t plane, uint32_t row) const { return before_[size_t{plane} * tiles_y_ + row]; }

 private:
  template <class CountMixed>
  void plan(const TileGrid& grid, CountMixed count_mixed);
  void divide(const TileGrid& grid);

  uint32_t tiles_y_ = 0;
  std::vector<uint32_t> before_;  // of each row of tiles of each plane, in the order of words
  std::vector<uint32_t> in_row_;  // mixed words of each row of tiles, of all planes
  std::vector<TileRows> rows_;
};

}  // namespace gnomon::protocol
