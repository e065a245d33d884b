// Where blocks of tiles were in a reference.
#pragma once

#include <span>

#include "common/packed_mask.h"
#include "protocol/context/bit_rows.h"
#include "protocol/context/camera_motion.h"
#include "protocol/context/slice_model.h"
#include "protocol/context/tile_walk.h"

namespace gnomon::protocol::context {

// Rows of blocks, [first, end).
struct BlockRows {
  uint32_t first = 0, end = 0;
};

// Of one light, whose `tiles` have a reference; `motions` has one for each block of kBlock x kBlock tiles, row by row, and
// is filled in for those of `rows`. What counts is the pixels that differ. Tried are what neighbours found and, for surfaces at all
// distances, where `camera` says that they were (null: places all around); then what is near the best, in steps that
// halve (T. Koga and others, "Motion-compensated interframe coding", 1981). What moves by itself is followed only as far
// as that goes.
void find_motions(const TileGrid& grid, const LightTiles& tiles, const CameraMotion* camera, const BlockRows& rows,
                  std::span<Motion> motions);

}  // namespace gnomon::protocol::context
