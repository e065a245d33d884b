// The LZ4 block format (lz4.org, lz4_Block_format.md), unpacked. Debian has the library for no target but its own.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

namespace gnomon::web {

// The number of bytes that were written to `out`, or nullopt if the block is malformed or does not fit. Blocks are
// refused exactly where LZ4_decompress_safe of lz4 1.9.4 refuses them, given as much room, so that browsers and native
// clients take the same slices.
std::optional<size_t> unpack_lz4_block(std::span<const uint8_t> block, std::span<uint8_t> out);

}  // namespace gnomon::web
