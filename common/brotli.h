// Brotli (RFC 7932), the compression that browsers undo by themselves.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/result.h"

namespace gnomon {

// For what is large and made while somebody waits. On packs of scenes (web_make_pack) 9 takes 5 to 20 times as long for
// 0.5 to 1% fewer bytes, 11 a minute for 10%.
inline constexpr int kBrotliQuality = 5;

// Blocking; any thread. `quality`: 0 to 11. Error: out of memory.
Result<std::vector<std::byte>> brotli(std::span<const std::byte> bytes, int quality = kBrotliQuality);

}  // namespace gnomon
