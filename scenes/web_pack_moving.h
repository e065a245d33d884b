// The moving geometry of a scene pack: not at a scene time, as world meshes have it, but in the spaces of its meshes, for
// readers who pose it themselves. Internal to scenes/.
#pragma once

#include <vector>

#include "scenes/geometry/clusters.h"
#include "scenes/scene.h"
#include "scenes/world_mesh.h"

namespace gnomon::scenes {

// A primitive of a moving instance. `first_vertex` and `first_triangle` count within MovingPart::mesh.
struct MovingInstance {
  uint32_t node = 0;
  uint32_t first_vertex = 0, vertices = 0;
  uint32_t first_triangle = 0, triangles = 0;
  bool flat = false;  // the file has no normals: they are those of the faces, once these are in the world
};

struct MovingPart {
  WorldMesh mesh;                         // in the spaces of the meshes; every triangle, with area or without
  std::vector<MovingInstance> instances;  // in the order of build_moving_mesh
  std::vector<ClusterGroup> groups;       // ranges of one kind, without chunks
};

MovingPart moving_part(const Scene& scene);

}  // namespace gnomon::scenes
