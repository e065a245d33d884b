// Where blocks of tiles were in a reference.
#pragma once

#include <span>

#include "common/packed_mask.h"
#include "protocol/context/bit_rows.h"
#include "protocol/context/camera_motion.h"
#include "protocol/context/slice_model.h"

namespace gnomon::protocol::context {

// Of one light; `motions` has one for each block of kBlock x kBlock tiles, row by row, and is filled in for those of
// block rows [first, end). What counts is the pixels that differ. Tried are what neighbours found and, for surfaces at all
// distances, where `camera` says that they were (null: places all around); then what is near the best, in steps that
// halve (T. Koga and others, "Motion-compensated interframe coding", 1981). What moves by itself is followed only as far
// as that goes.
void find_motions(const TileGrid& grid, std::span<const PackedClass> classes, std::span<const uint64_t> words,
                  const BitRows& reference, const CameraMotion* camera, uint32_t first, uint32_t end,
                  std::span<Motion> motions);

}  // namespace gnomon::protocol::context
