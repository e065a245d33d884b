#include "scenes/gltf/hierarchy.h"

#include <algorithm>
#include <cmath>

#include "scenes/pose.h"

namespace gnomon::scenes::gltf {
namespace {

// Copies `from` to `to`; an empty `from` leaves the default. Returns false unless there are n numbers, all finite.
template <size_t n>
bool take_numbers(const std::vector<double>& from, float (&to)[n]) {
  if (from.empty()) return true;
  if (from.size() != n) return false;
  for (size_t i = 0; i < n; ++i) {
    to[i] = static_cast<float>(from[i]);
    if (!std::isfinite(to[i])) return false;
  }
  return true;
}

Result<NodeTransform> transform_of(const tinygltf::Node& node) {
  float matrix[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  float translation[3] = {0, 0, 0};
  float rotation[4] = {0, 0, 0, 1};
  float scale[3] = {1, 1, 1};
  if (!take_numbers(node.matrix, matrix)) return Error{"has a matrix that is not 16 finite numbers"};
  if (!take_numbers(node.translation, translation)) return Error{"has a translation that is not 3 finite numbers"};
  if (!take_numbers(node.rotation, rotation)) return Error{"has a rotation that is not 4 finite numbers"};
  if (!take_numbers(node.scale, scale)) return Error{"has a scale that is not 3 finite numbers"};
  NodeTransform transform;
  transform.has_matrix = !node.matrix.empty();
  for (int column = 0; column < 4; ++column) {  // affine: the last row is (0, 0, 0, 1), whatever the file says
    for (int row = 0; row < 3; ++row) transform.matrix[column][row] = matrix[4 * column + row];
  }
  transform.translation = {translation[0], translation[1], translation[2]};
  transform.rotation = {rotation[3], rotation[0], rotation[1], rotation[2]};
  transform.scale = {scale[0], scale[1], scale[2]};
  return transform;
}

bool finite(const glm::dmat4& m) {
  for (int column = 0; column < 4; ++column) {
    for (int row = 0; row < 3; ++row) {
      if (!std::isfinite(static_cast<float>(m[column][row]))) return false;
    }
  }
  return true;
}

// The parent of each node, -1 for roots. Error: a node has two parents or a missing child, or lies on a cycle.
Result<std::vector<int>> parents_of(const tinygltf::Model& model) {
  std::vector<int> parents(model.nodes.size(), -1);
  for (size_t i = 0; i < parents.size(); ++i) {
    for (const int child : model.nodes[i].children) {
      if (const auto found = entry(model.nodes, child, "node"); !found) return found.error();
      int& parent = parents[static_cast<size_t>(child)];
      if (parent != -1) return Error{node_name(model, child) + " has two parents"};
      parent = static_cast<int>(i);
    }
  }
  // From each node one path leads upwards; a path that returns to a node of its own is a cycle.
  std::vector<size_t> seen_on(parents.size(), 0);  // 1 + the start of the path that visited the node first; 0: none
  for (size_t start = 0; start < parents.size(); ++start) {
    size_t node = start;
    for (; seen_on[node] == 0; node = static_cast<size_t>(parents[node])) {
      seen_on[node] = start + 1;
      if (parents[node] == -1) break;
    }
    if (parents[node] != -1 && seen_on[node] == start + 1) {
      return Error{node_name(model, static_cast<int>(node)) + " lies on a cycle"};
    }
  }
  return parents;
}

Result<std::vector<int>> roots_of(const tinygltf::Model& model) {
  const auto parents = parents_of(model);
  if (!parents) return parents.error();
  if (!model.scenes.empty()) {
    const auto scene = entry(model.scenes, std::max(model.defaultScene, 0), "scene");
    if (!scene) return scene.error();
    return (*scene)->nodes;
  }
  if (model.defaultScene != -1) return Error{"scene " + std::to_string(model.defaultScene) + " does not exist"};
  std::vector<int> roots;
  for (size_t i = 0; i < parents->size(); ++i) {
    if ((*parents)[i] == -1) roots.push_back(static_cast<int>(i));
  }
  return roots;
}

struct Waiting {
  int node;
  uint32_t parent;
};

class Walk {
 public:
  Walk(const tinygltf::Model& model, const LoadLimits& limits)
      : model_(model), limits_(limits), reached_(model.nodes.size(), false) {}

  Result<std::vector<PlacedNode>> from(const std::vector<int>& roots) {
    push(roots, kNone);
    while (!stack_.empty()) {
      const Waiting next = stack_.back();
      stack_.pop_back();
      if (const auto ok = place(next); !ok) return Error{node_name(model_, next.node) + " " + ok.error().message};
    }
    return std::move(placed_);
  }

 private:
  // Pushes the last node first, so that the stack returns them in order.
  void push(const std::vector<int>& nodes, uint32_t parent) {
    for (auto it = nodes.rbegin(); it != nodes.rend(); ++it) stack_.push_back({*it, parent});
  }

  Result<void> place(const Waiting& next) {
    if (next.node < 0 || static_cast<size_t>(next.node) >= reached_.size()) return Error{"does not exist"};
    const auto index = static_cast<size_t>(next.node);
    if (reached_[index]) return Error{"is reached twice by the scene"};
    reached_[index] = true;
    const tinygltf::Node& source = model_.nodes[index];
    Result<NodeTransform> local = transform_of(source);
    if (!local) return local.error();
    PlacedNode node{next.node, next.parent, 0, *local, local_transform(*local)};
    if (next.parent != kNone) {
      node.depth = placed_[next.parent].depth + 1;
      node.to_world = placed_[next.parent].to_world * node.to_world;
    }
    if (node.depth >= limits_.max_node_depth) {
      return Error{"lies deeper than " + std::to_string(limits_.max_node_depth) + " nodes"};
    }
    if (!finite(node.to_world)) return Error{"has a transform beyond what numbers can hold"};
    placed_.push_back(node);
    push(source.children, static_cast<uint32_t>(placed_.size()) - 1);
    return {};
  }

  const tinygltf::Model& model_;
  const LoadLimits& limits_;
  std::vector<bool> reached_;
  std::vector<Waiting> stack_;
  std::vector<PlacedNode> placed_;
};

}  // namespace

Result<std::vector<PlacedNode>> place_nodes(const tinygltf::Model& model, const LoadLimits& limits) {
  const auto roots = roots_of(model);
  if (!roots) return roots.error();
  return Walk(model, limits).from(*roots);
}

std::string node_name(const tinygltf::Model& model, int node) {
  const bool exists = node >= 0 && static_cast<size_t>(node) < model.nodes.size();
  const std::string name = exists ? model.nodes[static_cast<size_t>(node)].name : std::string();
  return "node " + std::to_string(node) + (name.empty() ? "" : " '" + name + "'");
}

}  // namespace gnomon::scenes::gltf
