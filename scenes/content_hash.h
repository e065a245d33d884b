// The content hash of a scene, and the bounds that the same walk over its triangles finds. Internal to scenes/.
#pragma once

#include "scenes/scene.h"

namespace gnomon::scenes {

struct Extent {
  ContentHash hash{};
  Bounds bounds;  // of what is drawn, at all scene times; zero if nothing is drawn
};

// The hash covers the corner positions of each triangle of build_world_mesh, as floats in its order (the tracers'
// caches refer to triangles by number); for triangles with an alpha test also the corners' uvs, base colour alpha,
// cutoff, and the texture's size, wrapping and alphas; which triangles are double-sided; type, position, direction,
// range and outer cone of each light; and for what moves the same at the scene time 0, the node that moves it, and its
// animations. It does not cover how the file arranges this into nodes, meshes, primitives and indices; names, colours,
// intensities, normals and cameras; and blended and degenerate triangles.
Extent measure(const Scene& scene);

}  // namespace gnomon::scenes
