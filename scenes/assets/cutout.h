// Images as PNG files, and those whose alpha cuts a shape out of a flat surface. Only the implementation uses stb.
#pragma once

#include <cstdint>
#include <vector>

namespace gnomon::scenes::assets {

// A square image of `size` x `size` texels with `channels` bytes each, rows from the top.
std::vector<uint8_t> png_of(int size, int channels, const std::vector<uint8_t>& texels);

// A five-lobed ivy leaf with its stalk at the middle of the lower edge.
std::vector<uint8_t> ivy_leaf_png();

// A lattice of `cells` x `cells` rings and bars, which tiles without seams.
std::vector<uint8_t> lattice_png(int cells);

}  // namespace gnomon::scenes::assets
