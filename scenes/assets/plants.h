// Plants of both scenes. Leaves are thin closed surfaces; ivy leaves are cards that a texture cuts out.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "scenes/assets/mesh.h"

namespace gnomon::scenes::assets {

// One leaf along +Y with its stalk at the origin and its upper side towards +Z: an oval that droops by `droop` of its
// length at the tip and folds along its middle rib.
Mesh leaf(float length, float width, float droop, int detail);

// A plant that rises from the origin, with separate meshes for wood and leaves.
struct Shrub {
  Mesh wood;
  Mesh leaves;
};
Shrub fig_tree(float height, uint32_t seed);
Shrub fern(float spread, int fronds, uint32_t seed);
Shrub snake_plant(float height, int blades, uint32_t seed);

// Ivy that grows from (0, 0, 0) over the plane z = 0 within `size`; its leaves are cards with texture coordinates.
Shrub ivy(glm::vec2 size, int stems, bool hanging, uint32_t seed);

}  // namespace gnomon::scenes::assets
