// A scene's geometry as one list of world-space triangles: the part that rests, and the moving part at a given time.
//
// The rasteriser, every tracer and the tests' oracle read these same floats, so that they can differ only in how they
// trace, not in what they trace.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/motion.h"
#include "scenes/scene.h"

namespace gnomon::scenes {

struct WorldMesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec3> normals;  // one for each position, unit; the face's if the file has none
  std::vector<glm::vec2> uvs;      // one for each position; zero if the file has none
  std::vector<glm::uvec3> triangles;
  std::vector<uint32_t> materials;  // one for each triangle
  // Opaque triangles come first, triangles with an alpha test follow; blended ones are left out.
  uint32_t opaque_count = 0;
};

// The winding of mirroring instances is reversed, so that a face's normal keeps pointing outwards. Triangles without
// area are left out, because they cover no pixel and block no light. Any thread.
WorldMesh build_world_mesh(const Scene& scene);                   // the part that rests
WorldMesh build_moving_mesh(const Scene& scene, SceneTime time);  // the moving part at that time

// Upper bounds of what build_world_mesh returns.
struct WorldMeshSize {
  uint64_t vertices = 0;
  uint64_t triangles = 0;
};
WorldMeshSize world_mesh_size(const Scene& scene);

// Upper bounds of what build_moving_mesh returns, for all times.
struct MovingMeshSize {
  uint32_t vertices = 0;
  uint32_t triangles = 0;
};
MovingMeshSize moving_mesh_size(const Scene& scene);

// The alpha test of one surface point, as in every tracer: nearest texel of level 0.
bool passes_alpha_test(const Scene& scene, uint32_t material, glm::vec2 uv);

}  // namespace gnomon::scenes
