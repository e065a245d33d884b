// What a device is given of a scene: its resting triangles in the order in which they are drawn, and their clusters.
#pragma once

#include <memory>

#include "scenes/geometry/clusters.h"
#include "scenes/scene.h"
#include "scenes/world_mesh.h"

namespace gnomon::scenes {

struct Geometry {
  WorldMesh mesh;  // reordered by make_clusters
  Clusters clusters;

  uint64_t memory_bytes() const;
};

// The memory of a scene that has its geometry, on the host and on a device with a hierarchy of its triangles, but without
// light buffers: an upper bound, known before the geometry is made.
uint64_t predicted_bytes(const Scene& scene);

// Blocking; any thread.
Geometry make_geometry(const Scene& scene, const OnShare& on_share = {});

// The scene's own, or made now if it has none.
GeometryPtr geometry_of(const Scene& scene);

}  // namespace gnomon::scenes
