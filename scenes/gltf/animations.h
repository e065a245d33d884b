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
  // All references outlive it.
  MovingNodes(const tinygltf::Model& model, const std::vector<PlacedNode>& placed, Animations& animations,
              const std::vector<NodeMotion>& motions);

  // Of a placed node that carries something: its index in nodes(), kNone where it rests. Error: as Animations::of.
  Result<uint32_t> find(uint32_t placed);

  // When all nodes were found: the time of the longest animation, until which the given motions are repeated. Error:
  // one of them moves nothing, or is too fast for that.
  Result<std::chrono::microseconds> fill_period();

  std::vector<MovingNode>& nodes() { return nodes_; }

 private:
  // Of a moving node and a motion that was given to it.
  struct Given {
    uint32_t node;
    const NodeMotion* motion;
  };

  bool is_given_motion(const PlacedNode& node) const;
  std::chrono::microseconds longest() const;

  const tinygltf::Model& model_;
  const std::vector<PlacedNode>& placed_;
  Animations& animations_;
  std::vector<bool> moved_;      // for each placed node: itself, or through an ancestor
  std::vector<uint32_t> index_;  // for each placed node, kNone: not yet
  std::vector<MovingNode> nodes_;
  const std::vector<NodeMotion>& motions_;
  std::vector<Given> given_;
};

}  // namespace gnomon::scenes::gltf
