// Sculpted shapes: solids given by a distance field, negative inside, and meshed with naive surface nets.
#pragma once

#include <functional>
#include <glm/glm.hpp>

#include "scenes/assets/mesh.h"

namespace gnomon::scenes::assets {

using Field = std::function<float(glm::vec3)>;

// Unions whose seam is rounded over about `k` metres, and its opposite.
float blend(float a, float b, float k);
float carve(float solid, float hole, float k);

// Distances (ellipsoid: a close bound) to simple solids.
float ball(glm::vec3 p, glm::vec3 centre, float radius);
float ellipsoid(glm::vec3 p, glm::vec3 centre, glm::vec3 radii);
float capsule(glm::vec3 p, glm::vec3 a, glm::vec3 b, float radius_a, float radius_b);
float brick(glm::vec3 p, glm::vec3 centre, glm::vec3 half, float round);

// The zero surface within the box, which must hold all of the solid, from cubic cells of size `cell`.
Mesh sculpt(const Field& field, glm::vec3 low, glm::vec3 high, float cell);

}  // namespace gnomon::scenes::assets
