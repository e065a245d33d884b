#include "scenes/gltf/cameras.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <optional>
#include <string>

#include "scenes/gltf/accessor.h"
#include "scenes/pose.h"

namespace gnomon::scenes::gltf {
namespace {

// Placed nodes from the root to `node`.
std::vector<uint32_t> chain_to(const std::vector<PlacedNode>& nodes, uint32_t node) {
  std::vector<uint32_t> chain;
  for (uint32_t n = node; n != kNone; n = nodes[n].parent) chain.push_back(n);
  std::reverse(chain.begin(), chain.end());
  return chain;
}

std::optional<Channel::Path> path_of(const std::string& name) {
  if (name == "translation") return Channel::Path::translation;
  if (name == "rotation") return Channel::Path::rotation;
  if (name == "scale") return Channel::Path::scale;
  return std::nullopt;
}

Result<Interpolation> interpolation_of(const std::string& name) {
  if (name == "LINEAR" || name.empty()) return Interpolation::linear;
  if (name == "STEP") return Interpolation::step;
  if (name == "CUBICSPLINE") return Interpolation::cubic_spline;
  return Error{"has the unknown interpolation '" + name + "'"};
}

Result<std::vector<float>> read_times(const Document& document, int accessor) {
  const auto elements = Elements::of(document, accessor, TINYGLTF_TYPE_SCALAR);
  if (!elements) return elements.error();
  std::vector<float> times(elements->count());
  for (size_t i = 0; i < times.size(); ++i) {
    times[i] = elements->at(i).x;
    const bool later = i == 0 ? times[i] >= 0.0f : times[i] > times[i - 1];
    if (!later || !std::isfinite(times[i])) return Error{"has times that do not increase"};
  }
  if (times.empty()) return Error{"has no times"};
  return times;
}

Result<std::vector<glm::vec4>> read_values(const Document& document, int accessor, const Channel& channel) {
  const bool rotation = channel.path == Channel::Path::rotation;
  const auto elements = Elements::of(document, accessor, rotation ? TINYGLTF_TYPE_VEC4 : TINYGLTF_TYPE_VEC3);
  if (!elements) return elements.error();
  const size_t per_key = channel.interpolation == Interpolation::cubic_spline ? 3 : 1;
  if (elements->count() != per_key * channel.times.size()) {
    return Error{"has " + std::to_string(elements->count()) + " values for " +
                 std::to_string(channel.times.size()) + " times"};
  }
  std::vector<glm::vec4> values(elements->count());
  for (size_t i = 0; i < values.size(); ++i) {
    values[i] = elements->at(i);
    if (!std::isfinite(glm::dot(values[i], values[i]))) return Error{"has a value that is not a finite number"};
  }
  return values;
}

Result<Channel> read_channel(const Document& document, const tinygltf::Animation& animation, int sampler_index,
                             Channel::Path path) {
  const auto sampler = entry(animation.samplers, sampler_index, "animation sampler");
  if (!sampler) return sampler.error();
  const auto interpolation = interpolation_of((*sampler)->interpolation);
  if (!interpolation) return interpolation.error();
  Channel channel;
  channel.path = path;
  channel.interpolation = *interpolation;
  auto times = read_times(document, (*sampler)->input);
  if (!times) return times.error();
  channel.times = std::move(*times);
  auto values = read_values(document, (*sampler)->output, channel);
  if (!values) return values.error();
  channel.values = std::move(*values);
  return channel;
}

bool has_channel(const CameraPath& path, uint32_t node, Channel::Path property) {
  return std::any_of(path.channels.begin(), path.channels.end(),
                     [&](const Channel& c) { return c.node == node && c.path == property; });
}

// Adds what an animation does to the nodes of the path's chain.
Result<void> add_channels(const Document& document, const tinygltf::Animation& animation,
                          const std::vector<int>& chain, CameraPath& path) {
  for (const tinygltf::AnimationChannel& source : animation.channels) {
    const auto link = std::find(chain.begin(), chain.end(), source.target_node);
    const auto property = path_of(source.target_path);
    if (source.target_node < 0 || link == chain.end() || !property) continue;
    const auto node = static_cast<uint32_t>(link - chain.begin());
    if (path.chain[node].has_matrix || has_channel(path, node, *property)) continue;
    Result<Channel> channel = read_channel(document, animation, source.sampler, *property);
    if (!channel) return Error{"animation '" + animation.name + "' " + channel.error().message};
    channel->node = node;
    path.duration_seconds = std::max(path.duration_seconds, channel->times.back());
    path.channels.push_back(std::move(*channel));
  }
  return {};
}

Result<CameraPath> read_path(const Document& document, const std::vector<PlacedNode>& nodes, uint32_t node) {
  CameraPath path;
  std::vector<int> chain;  // indices in the file
  for (const uint32_t link : chain_to(nodes, node)) {
    chain.push_back(nodes[link].node);
    path.chain.push_back(nodes[link].local);
  }
  for (const tinygltf::Animation& animation : document.model.animations) {
    if (const auto ok = add_channels(document, animation, chain, path); !ok) return ok.error();
  }
  return path;
}

Result<float> field_of_view(const tinygltf::Camera& camera) {
  const double yfov = camera.perspective.yfov;
  if (!(yfov > 0.0) || yfov >= glm::pi<double>()) {
    return Error{"camera '" + camera.name + "' has a vertical field of view that is not between 0 and pi"};
  }
  return static_cast<float>(yfov);
}

}  // namespace

Result<Cameras> read_cameras(const Document& document, const std::vector<PlacedNode>& nodes) {
  Cameras out;
  for (uint32_t i = 0; i < nodes.size(); ++i) {
    const tinygltf::Node& node = document.model.nodes[static_cast<size_t>(nodes[i].node)];
    if (node.camera == -1) continue;
    const auto source = entry(document.model.cameras, node.camera, "camera");
    if (!source) return Error{node_name(document.model, nodes[i].node) + ": " + source.error().message};
    if ((*source)->type != "perspective") continue;
    const Result<float> fov = field_of_view(**source);
    if (!fov) return fov.error();
    Result<CameraPath> path = read_path(document, nodes, i);
    if (!path) return path.error();
    path->camera = static_cast<uint32_t>(out.cameras.size());
    const std::string name = (*source)->name.empty() ? node.name : (*source)->name;
    out.cameras.push_back({name, pose_from_transform(nodes[i].to_world, *fov)});
    if (!path->channels.empty()) out.paths.push_back(std::move(*path));
  }
  return out;
}

}  // namespace gnomon::scenes::gltf
