// Codes one tile of one light as a class and, if it is not uniform, a few bytes. WIRE.md has the format.
#pragma once

#include <cstdint>
#include <span>

namespace gnomon::protocol {

// Two bits on the wire.
//   dark, lit  all 64 bits 0, all 1: no bytes
//   line       2 bytes. The border of a straight shadow: every row is a run of ones that touches the left or the
//              right side, and from row to row the run grows or shrinks, by one pixel or none, always the same way;
//              or the same with columns for rows
//   rows       any other tile, 1 to 9 bytes: which rows differ from the row above, and these rows
enum class TileClass : uint8_t { dark = 0, lit = 1, line = 2, rows = 3 };

inline constexpr size_t kMaxTileBytes = 9;

// Encodes a tile that is neither dark nor lit: writes its bytes to `out`, which has room for kMaxTileBytes, and
// advances `out` past them.
TileClass encode_tile(uint64_t word, uint8_t*& out);

// Decodes a tile of class line or rows: takes its bytes off the front of `bytes`; false if there are too few.
bool decode_tile(TileClass tile_class, std::span<const uint8_t>& bytes, uint64_t& word);

}  // namespace gnomon::protocol
