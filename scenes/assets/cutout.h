// Small pictures whose alpha cuts a shape out of a flat piece, as PNG files. stb stands behind this header alone.
#pragma once

#include <cstdint>
#include <vector>

namespace gnomon::scenes::assets {

// A five-lobed ivy leaf, its stalk at the middle of the lower edge.
std::vector<uint8_t> ivy_leaf_png();

// A lattice of rings and bars, `cells` x `cells` of them, that meets itself at the edges.
std::vector<uint8_t> lattice_png(int cells);

}  // namespace gnomon::scenes::assets
