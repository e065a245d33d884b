// The node hierarchy: places the nodes of a file in the world. Internal to scenes/gltf/.
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
  uint32_t parent = kNone;  // index among the placed nodes, less than this node's own
  uint32_t depth = 0;
  NodeTransform local;
  glm::dmat4 to_world{1.0};
};

// The nodes of the default scene (the first scene if the file names none; all roots if it has no scenes), parents
// before children, in the file's order. Error: a node does not exist, has two parents, lies on a cycle or too deep, or
// has a transform that is not valid.
Result<std::vector<PlacedNode>> place_nodes(const tinygltf::Model& model, const LoadLimits& limits);

// The node's name in error messages: "node 3 'lamp'".
std::string node_name(const tinygltf::Model& model, int node);

}  // namespace gnomon::scenes::gltf
