// The colours of debug pictures, and their legend in words for --help.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"
#include "gpu/tracers/light_buffer/query.h"

namespace gnomon::client {

enum class DebugKind {
  mask,    // the bits that arrived
  bounds,  // where the light buffer's query ends
  lists,   // how many triangles it tests
};

// Error: names the allowed kinds.
Result<DebugKind> parse_debug_kind(std::string_view name);
const char* to_string(DebugKind kind);

// The meaning of the colours of all kinds, in several lines.
std::string debug_legend();

using Colour = std::array<uint8_t, 3>;

inline constexpr Colour kNoSurface{0, 0, 0};
inline constexpr Colour kNotAsked{70, 70, 85};  // behind the surface, out of range or cone

Colour mask_colour(uint32_t seen, uint32_t samples);  // between those of none and of all
Colour bounds_colour(const gpu::light_buffer::Answer& answer);
// A colour for each power of two: 0, 1, 2 to 3, 4 to 7, ... 64 and more.
Colour lists_colour(uint32_t tested);

}  // namespace gnomon::client
