// Where blocks of tiles were in a reference.
#pragma once

#include <span>

#include "common/packed_mask.h"
#include "protocol/context/bit_rows.h"
#include "protocol/context/slice_model.h"

namespace gnomon::protocol::context {

// Of one light; `motions` has one for each block of kBlock x kBlock tiles, row by row, and is filled in for those of
// block rows [first, end). The steps of the search halve (T. Koga and others, "Motion-compensated interframe coding",
// 1981), beginning at what neighbours found; what counts is the pixels that differ.
void find_motions(const TileGrid& grid, std::span<const PackedClass> classes, std::span<const uint64_t> words,
                  const BitRows& reference, uint32_t first, uint32_t end, std::span<Motion> motions);

}  // namespace gnomon::protocol::context
