// The mesh of the target packed_builds and of its seeds: a fan of eight triangles, the last two with an alpha test.
#pragma once

#include "scenes/world_mesh.h"

namespace gnomon::fuzz {

inline scenes::WorldMesh small_mesh() {
  scenes::WorldMesh mesh;
  mesh.positions = {{0, 0, 0}};
  for (uint32_t i = 0; i < 9; ++i) mesh.positions.emplace_back(1.0f + float(i), float(i * i), float(i % 3));
  for (uint32_t i = 1; i < 9; ++i) mesh.triangles.emplace_back(0u, i, i + 1);
  mesh.normals.resize(mesh.positions.size());
  mesh.uvs.resize(mesh.positions.size());
  mesh.materials.resize(mesh.triangles.size());
  mesh.opaque_count = 6;
  return mesh;
}

}  // namespace gnomon::fuzz
