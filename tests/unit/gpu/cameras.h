// Cameras that look at a scene from everywhere, to find what goes wrong only sometimes.
#pragma once

#include <random>

#include "gpu/renderer.h"
#include "scenes/world_mesh.h"

namespace gnomon::test {

class Cameras {
 public:
  Cameras(const scenes::Scene& scene, uint32_t seed);

  // Kinds in turn: within the scene, on a surface, far away, a crooked narrow view, a near plane that cuts much away.
  gpu::CameraView next();

 private:
  float any() { return std::uniform_real_distribution<float>(-1.0f, 1.0f)(random_); }
  glm::vec3 within();
  glm::vec3 on_surface();
  gpu::CameraView from_afar(float distance);

  std::mt19937 random_;
  uint32_t kind_ = 0;
  scenes::Bounds bounds_;
  scenes::WorldMesh mesh_;
};

}  // namespace gnomon::test
