// Animations of nodes: from the file, and those given beside it. Internal to scenes/gltf/.
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

  // Whether an animation moves the node itself. glTF 2.0 allows no animation of a node with a matrix; it is ignored.
  bool move(const PlacedNode& node) const;

  // One channel for each property that is animated; if several animations target the same property, the first is taken.
  // Error: a channel is not valid, or all channels read so far have more values than a file may ask for.
  Result<std::vector<Channel>> of(const PlacedNode& node);

  Budget& budget() const { return document_.budget; }

 private:
  struct Source {
    const tinygltf::Animation* animation;
    const tinygltf::AnimationChannel* channel;
  };

  const Document& document_;
  std::unordered_map<int, std::vector<Source>> by_node_;
};

// Collects the moving nodes that carry a mesh or a light, and their moving ancestors, for Scene::moving_nodes.
class MovingNodes {
 public:
  // All references must outlive the object.
  MovingNodes(const tinygltf::Model& model, const std::vector<PlacedNode>& placed, Animations& animations,
              const std::vector<NodeMotion>& motions);

  // The index in nodes() of a placed node that carries something, which is added at the first call; kNone if the node
  // rests. Error: as Animations::of.
  Result<uint32_t> find(uint32_t placed);

  // To be called after find() was called for all nodes. Returns the duration of the longest animation, and repeats the
  // given motions until then. Error: a given motion moves nothing, or would be repeated more than 1000 times.
  Result<std::chrono::microseconds> fill_period();

  std::vector<MovingNode>& nodes() { return nodes_; }

 private:
  // A motion that was given to the moving node of that index.
  struct Given {
    uint32_t node;
    const NodeMotion* motion;
  };

  bool is_given_motion(const PlacedNode& node) const;
  std::chrono::microseconds longest() const;

  const tinygltf::Model& model_;
  const std::vector<PlacedNode>& placed_;
  Animations& animations_;
  std::vector<bool> moved_;      // for each placed node: whether it moves, itself or through an ancestor
  std::vector<uint32_t> index_;  // for each placed node: its index in nodes_; kNone if it was not added yet
  std::vector<MovingNode> nodes_;
  const std::vector<NodeMotion>& motions_;
  std::vector<Given> given_;
};

}  // namespace gnomon::scenes::gltf
