// Textures as shaders read them.
#pragma once

#include <cstdint>
#include <vector>

#include "scenes/scene.h"

namespace gnomon::gpu {

// RGBA8, red in the lowest byte: alpha as the file has it, and each colour as 255 times the square root of its linear
// value, which a shader undoes with one multiplication where the file's sRGB takes a power.
struct Texels {
  std::vector<uint32_t> rgba;  // the levels one behind the other, rows from the top
  uint32_t levels = 1;
};

// Level 0 alone, which is all that alpha tests read.
Texels flat_texels(const scenes::Texture& texture);
// With mip levels down to one texel: each half the size of the one before, rounded down, and its texels the means of
// four in linear light.
Texels mipmapped_texels(const scenes::Texture& texture);

}  // namespace gnomon::gpu
