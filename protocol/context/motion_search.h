// Finds where blocks of tiles were in a reference.
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

// Finds the motions of one light's blocks. Precondition: `tiles` has a reference. `motions` has an entry for each block
// of kBlock x kBlock tiles, row by row; those of `rows` are written. The cost of a motion is the number of pixels of
// mixed tiles that differ, plus the price of coding it. Candidates are the neighbours' motions and, with `camera`,
// where surfaces at all distances were if they stand still; without it (null), places all around. The best is then
// refined in steps that halve, as in the three-step search (T. Koga and others, "Motion-compensated interframe coding
// for video conferencing", 1981). Surfaces that move by themselves are followed only as far as the refinement reaches.
void find_motions(const TileGrid& grid, const LightTiles& tiles, const CameraMotion* camera, const BlockRows& rows,
                  std::span<Motion> motions);

}  // namespace gnomon::protocol::context
