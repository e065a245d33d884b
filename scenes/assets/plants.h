// Plants of both scenes. Leaves are closed and thin; ivy is cut out of cards by its texture.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "scenes/assets/mesh.h"

namespace gnomon::scenes::assets {

// One leaf from its stalk at the origin along +Y, its upper side towards +Z: an oval that droops by `droop` of its
// length at the tip and folds along its middle rib.
Mesh leaf(float length, float width, float droop, int detail);

// Stems with broad leaves that rise from the origin to about `height`; wood and leaves apart.
struct Shrub {
  Mesh wood;
  Mesh leaves;
};
Shrub fig_tree(float height, uint32_t seed);
Shrub fern(float spread, int fronds, uint32_t seed);
Shrub snake_plant(float height, int blades, uint32_t seed);

// Ivy over the plane z = 0, growing from (0, 0, 0) within `size`; leaves are cards with texture coordinates.
Shrub ivy(glm::vec2 size, int stems, bool hanging, uint32_t seed);

}  // namespace gnomon::scenes::assets
