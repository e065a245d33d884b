// Cameras and the animations that move them. Internal to scenes/gltf/.
#pragma once

#include <vector>

#include "common/result.h"
#include "scenes/gltf/animations.h"
#include "scenes/gltf/document.h"
#include "scenes/gltf/hierarchy.h"
#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

struct Cameras {
  std::vector<Camera> cameras;
  std::vector<CameraPath> paths;
};

// Reads a camera for each node that carries one, and a path for each camera that an animation moves, itself or through
// its ancestors. Orthographic cameras are left out, because all rays of a frame start at one point.
Result<Cameras> read_cameras(const Document& document, const std::vector<PlacedNode>& nodes,
                             Animations& animations);

}  // namespace gnomon::scenes::gltf
