// A scene's geometry as one list of world-space triangles: what rests, and what moves as it is at a time.
//
// Raster, every tracer and the oracle of the tests read these same floats, so that they can only differ in how
// they trace, never in what.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/motion.h"
#include "scenes/scene.h"

namespace gnomon::scenes {

struct WorldMesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  // one for each position, unit; the face's where the file has none
  std::vector<glm::vec2> uvs;      // one for each position; zero where the file has none
  std::vector<glm::uvec3> triangles;
  std::vector<uint32_t> materials;  // one for each triangle
  // Opaque triangles come first, those with an alpha test follow; blended ones are left out.
  uint32_t opaque_count = 0;
};

// Mirroring instances have their winding turned back, so that a face's normal keeps pointing outwards.
// Triangles without area are left out: they cover no pixel and block no light.
WorldMesh build_world_mesh(const Scene& scene);                   // what rests
WorldMesh build_moving_mesh(const Scene& scene, SceneTime time);  // what moves, each time anew

// What build_moving_mesh gives at most, at any time.
struct MovingMeshSize {
  uint32_t vertices = 0;
  uint32_t triangles = 0;
};
MovingMeshSize moving_mesh_size(const Scene& scene);

// The alpha test of one surface point, the same in every tracer: nearest texel of level 0.
bool passes_alpha_test(const Scene& scene, uint32_t material, glm::vec2 uv);

}  // namespace gnomon::scenes
