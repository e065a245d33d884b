// JPEG files for tests: grey, of nothing but their headers.
#pragma once

#include <cstdint>
#include <vector>

namespace gnomon::scenes::testing {

// Says that it is so large, has `scans` scans (1 or more, progressive) and almost no data in them.
std::vector<uint8_t> jpeg(uint16_t width, uint16_t height, uint32_t scans);

}  // namespace gnomon::scenes::testing
