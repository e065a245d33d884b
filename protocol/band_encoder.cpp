#include "protocol/band_encoder.h"

#include <algorithm>

namespace gnomon::protocol {

void BandEncoder::encode(const PackedMaskView& frame, const BandPlan& plan, size_t band, size_t max_payload_bytes,
                         EncodedMask& out) {
  coded_.code(frame, plan, band);
  cut(frame.grid, plan.rows(band), max_payload_bytes, out);
}

void BandEncoder::encode(const TileMaskView& frame, const BandPlan& plan, size_t band, size_t max_payload_bytes,
                         EncodedMask& out) {
  coded_.code(frame, plan, band);
  cut(frame.grid, plan.rows(band), max_payload_bytes, out);
}

// The band is cut as a frame of its own, whose slices are then moved to where it lies.
void BandEncoder::cut(const TileGrid& grid, TileRows rows, size_t max_payload_bytes, EncodedMask& out) {
  const size_t before = out.slices.size();
  const TileGrid of_band{grid.width, std::min(grid.height - rows.first * kTileSize, rows.count * kTileSize),
                         grid.planes};
  cutter_.cut_tiles(coded_, of_band, max_payload_bytes, out);
  for (size_t i = before; i < out.slices.size(); ++i) out.slices[i].first_tile += rows.first * grid.tiles_x();
}

}  // namespace gnomon::protocol
