// What animations do to nodes. Internal to scenes/gltf/.
#pragma once

#include <unordered_map>
#include <vector>

#include "common/result.h"
#include "scenes/gltf/document.h"
#include "scenes/gltf/hierarchy.h"
#include "scenes/scene.h"

namespace gnomon::scenes::gltf {

// The animations of a file by the node that they move. Borrows from the document.
class Animations {
 public:
  explicit Animations(const Document& document);

  // Whether one moves the node itself. A node with a matrix is moved by none (glTF 2.0, 3.11).
  bool move(const PlacedNode& node) const;

  // A channel for each property that is moved; where several animations move the same one, the first counts.
  // Error: one that is not valid, or more keys than a file may ask for in all.
  Result<std::vector<Channel>> of(const PlacedNode& node);

 private:
  struct Source {
    const tinygltf::Animation* animation;
    const tinygltf::AnimationChannel* channel;
  };

  const Document& document_;
  std::unordered_map<int, std::vector<Source>> by_node_;
  size_t values_left_;
};

// The nodes that carry something and move, for Scene::moving_nodes.
class MovingNodes {
 public:
  MovingNodes(const std::vector<PlacedNode>& placed, Animations& animations);

  // Of a placed node that carries something: its index in nodes(), kNone where it rests. Error: as Animations::of.
  Result<uint32_t> find(uint32_t placed);

  std::vector<MovingNode>& nodes() { return nodes_; }
  std::chrono::microseconds period() const;

 private:
  const std::vector<PlacedNode>& placed_;
  Animations& animations_;
  std::vector<bool> moved_;      // for each placed node: itself, or through an ancestor
  std::vector<uint32_t> index_;  // for each placed node, kNone: not yet
  std::vector<MovingNode> nodes_;
};

}  // namespace gnomon::scenes::gltf
