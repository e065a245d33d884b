#include "scenes/gltf/cameras.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <string>

#include "scenes/pose.h"

namespace gnomon::scenes::gltf {
namespace {

// The placed nodes from the root to `node`, both included.
std::vector<uint32_t> chain_to(const std::vector<PlacedNode>& nodes, uint32_t node) {
  std::vector<uint32_t> chain;
  for (uint32_t n = node; n != kNone; n = nodes[n].parent) chain.push_back(n);
  std::reverse(chain.begin(), chain.end());
  return chain;
}

constexpr size_t kMaxCameras = 1024;

// The path of a camera; without channels if the camera does not move.
Result<CameraPath> read_path(const std::vector<PlacedNode>& nodes, uint32_t camera_node, Animations& animations) {
  CameraPath path;
  for (const uint32_t link : chain_to(nodes, camera_node)) {
    auto channels = animations.of(nodes[link]);
    if (!channels) return channels.error();
    for (Channel& channel : *channels) {
      channel.node = static_cast<uint32_t>(path.chain.size());
      path.duration_seconds = std::max(path.duration_seconds, channel.times.back());
      path.channels.push_back(std::move(channel));
    }
    path.chain.push_back(nodes[link].local);
  }
  return path;
}

Result<float> field_of_view(const tinygltf::Camera& camera) {
  const auto yfov = static_cast<float>(camera.perspective.yfov);
  const float half = std::tan(yfov / 2);
  if (!(yfov > 0.0f && yfov < glm::pi<float>() && half > 0.0f && std::isfinite(half))) {
    return Error{"camera '" + camera.name + "' has a vertical field of view that is not between 0 and pi"};
  }
  return yfov;
}

}  // namespace

Result<Cameras> read_cameras(const Document& document, const std::vector<PlacedNode>& nodes,
                             Animations& animations) {
  Cameras out;
  for (uint32_t i = 0; i < nodes.size(); ++i) {
    const tinygltf::Node& node = document.model.nodes[static_cast<size_t>(nodes[i].node)];
    if (node.camera == -1) continue;
    const auto source = entry(document.model.cameras, node.camera, "camera");
    if (!source) return Error{node_name(document.model, nodes[i].node) + ": " + source.error().message};
    if ((*source)->type != "perspective") continue;
    const Result<float> fov = field_of_view(**source);
    if (!fov) return fov.error();
    Result<CameraPath> path = read_path(nodes, i, animations);
    if (!path) return path.error();
    if (out.cameras.size() == kMaxCameras)
      return Error{"it has more than " + std::to_string(kMaxCameras) + " cameras"};
    path->camera = static_cast<uint32_t>(out.cameras.size());
    const std::string name = (*source)->name.empty() ? node.name : (*source)->name;
    out.cameras.push_back({name, pose_from_transform(nodes[i].to_world, *fov)});
    if (!path->channels.empty()) out.paths.push_back(std::move(*path));
  }
  return out;
}

}  // namespace gnomon::scenes::gltf
