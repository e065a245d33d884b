// PNG files for tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace gnomon::scenes::testing {

// `rgba`: 4 bytes a texel, rows from the top.
std::vector<uint8_t> png(uint32_t width, uint32_t height, const std::vector<uint8_t>& rgba);

// Says that it is 1 x 1 texels, and unpacks to `unpacked_bytes`.
std::vector<uint8_t> png_bomb(std::size_t unpacked_bytes);

}  // namespace gnomon::scenes::testing
