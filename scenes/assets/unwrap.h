// Texture coordinates for models that were made without any.
#pragma once

#include "scenes/assets/mesh.h"

namespace gnomon::scenes::assets {

// The mesh with coordinates of a texture that spans `metres` of its surface. Each connected piece is projected along the
// three axes, every triangle along the one that it faces most, with u along the piece's longest side, as a carpenter
// cuts boards; and each piece starts at another place of the texture, so that no two look alike. Vertices that lie
// between two projections are doubled; triangles keep their order and their corners' positions and normals.
Mesh unwrapped(const Mesh& mesh, float metres);

}  // namespace gnomon::scenes::assets
