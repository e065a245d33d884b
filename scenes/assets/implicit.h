// Sculpted shapes: solids given by a signed distance field, negative inside, and meshed with naive surface nets (after
// Gibson, "Constrained Elastic Surface Nets", 1998, without the relaxation).
#pragma once

#include <functional>
#include <glm/glm.hpp>

#include "scenes/assets/mesh.h"

namespace gnomon::scenes::assets {

using Field = std::function<float(glm::vec3)>;

// The union of two solids with a seam rounded over about `k` metres (Quilez's quadratic polynomial smooth minimum), and
// the difference of two solids with such a seam.
float blend(float a, float b, float k);
float carve(float solid, float hole, float k);

// Signed distances to simple solids; an approximation for the ellipsoid, and for a capsule whose radii differ.
float ball(glm::vec3 p, glm::vec3 centre, float radius);
float ellipsoid(glm::vec3 p, glm::vec3 centre, glm::vec3 radii);
float capsule(glm::vec3 p, glm::vec3 a, glm::vec3 b, float radius_a, float radius_b);
float brick(glm::vec3 p, glm::vec3 centre, glm::vec3 half, float round);

// Meshes the zero surface within the box from cubic cells of size `cell`. Precondition: the box contains the solid.
Mesh sculpt(const Field& field, glm::vec3 low, glm::vec3 high, float cell);

}  // namespace gnomon::scenes::assets
