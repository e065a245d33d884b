// The content hash of a scene, and the bounds that the same walk over its triangles finds. Internal to scenes/.
#pragma once

#include "scenes/scene.h"

namespace gnomon::scenes {

struct Extent {
  ContentHash hash{};
  Bounds bounds;  // of what is drawn, wherever it moves; zero where nothing is drawn
};

// Counts: the corner positions of each triangle of build_world_mesh, as floats in its order (caches of tracers
// speak of triangles by their number); of those with an alpha test also the corners' uvs, base colour alpha,
// cutoff, and the texture's size, wrapping and alphas; which triangles are double-sided; of lights type, position,
// direction, range and outer cone; of what moves the same at the scene time 0, which node moves it, and how.
// Does not count: how the file arranges this into nodes, meshes, primitives and indices; names, colours,
// intensities, normals, cameras, blended and degenerate triangles.
Extent measure(const Scene& scene);

}  // namespace gnomon::scenes
