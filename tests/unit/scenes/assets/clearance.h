// How far a point is from what is built, and on which side of it: brute force over the world's triangles.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scenes/assets/stage.h"

namespace gnomon::scenes::assets {

class World {
 public:
  explicit World(const Stage& stage);

  // Distance to the nearest surface, or `limit` if there is none nearer.
  float clearance(glm::vec3 point, float limit) const;

  // False when the first surface met in `direction` shows its back: the point lies inside a closed solid. Sheets
  // with an alpha test have no inside and are passed over.
  bool in_free_space(glm::vec3 point, glm::vec3 direction) const;

 private:
  struct Piece {
    glm::vec3 low, high;
    bool closed;
    std::vector<glm::vec3> corners;  // three a triangle
  };
  std::vector<Piece> pieces_;
};

}  // namespace gnomon::scenes::assets
