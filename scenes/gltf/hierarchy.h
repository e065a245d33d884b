// The node hierarchy: what of a file stands where in the world. Internal to scenes/gltf/.
#pragma once

#include <glm/glm.hpp>
#include <string>
#include <vector>

#include "common/result.h"
#include "scenes/gltf/document.h"
#include "scenes/loader.h"
#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

// A node that the scene reaches.
struct PlacedNode {
  int node = -1;            // index in the file
  uint32_t parent = kNone;  // index among the placed nodes, always a smaller one
  uint32_t depth = 0;
  NodeTransform local;
  glm::dmat4 to_world{1.0};
};

// The nodes of the default scene (the first, where the file names none; all roots, where it has no scenes), parents
// before children, in the file's order. Error: a node that does not exist, has two parents, lies on a cycle or too
// deep, or has a transform that is not valid.
Result<std::vector<PlacedNode>> place_nodes(const tinygltf::Model& model, const LoadLimits& limits);

// "node 3 'lamp'", for errors.
std::string node_name(const tinygltf::Model& model, int node);

}  // namespace gnomon::scenes::gltf
