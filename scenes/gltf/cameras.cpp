#include "scenes/gltf/cameras.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <optional>
#include <string>
#include <unordered_map>

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

// What a file may ask for: paths copy the nodes and keys of ancestors that they share.
constexpr size_t kMaxCameras = 1024;
constexpr size_t kMaxValues = size_t{1} << 23;

// Builds the paths of cameras, looking each node's animations up where searching would take cameras x channels.
class PathReader {
 public:
  PathReader(const Document& document, const std::vector<PlacedNode>& nodes) : document_(document), nodes_(nodes) {
    for (const tinygltf::Animation& animation : document.model.animations) {
      for (const tinygltf::AnimationChannel& channel : animation.channels) {
        moving_[channel.target_node].push_back({&animation, &channel});
      }
    }
  }

  Result<CameraPath> read(uint32_t camera_node) {
    CameraPath path;
    for (const uint32_t link : chain_to(nodes_, camera_node)) {
      path.chain.push_back(nodes_[link].local);
      const auto moved = moving_.find(nodes_[link].node);
      if (moved == moving_.end() || nodes_[link].local.has_matrix) continue;
      if (const auto ok = add_channels(moved->second, path); !ok) return ok.error();
    }
    return path;
  }

 private:
  struct Source {
    const tinygltf::Animation* animation;
    const tinygltf::AnimationChannel* channel;
  };

  // What animations do to the last node of the path's chain: the first that moves a property counts.
  Result<void> add_channels(const std::vector<Source>& sources, CameraPath& path) {
    std::array<bool, 3> taken{};
    for (const Source& source : sources) {
      const auto property = path_of(source.channel->target_path);
      if (!property || taken[static_cast<size_t>(*property)]) continue;
      taken[static_cast<size_t>(*property)] = true;
      Result<Channel> channel = read_channel(document_, *source.animation, source.channel->sampler, *property);
      if (!channel) return Error{"animation '" + source.animation->name + "' " + channel.error().message};
      if (channel->values.size() > values_left_) return Error{"its camera animations have too many keys"};
      values_left_ -= channel->values.size();
      channel->node = static_cast<uint32_t>(path.chain.size()) - 1;
      path.duration_seconds = std::max(path.duration_seconds, channel->times.back());
      path.channels.push_back(std::move(*channel));
    }
    return {};
  }

  const Document& document_;
  const std::vector<PlacedNode>& nodes_;
  std::unordered_map<int, std::vector<Source>> moving_;  // by node of the file
  size_t values_left_ = kMaxValues;
};

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
  PathReader paths(document, nodes);
  for (uint32_t i = 0; i < nodes.size(); ++i) {
    const tinygltf::Node& node = document.model.nodes[static_cast<size_t>(nodes[i].node)];
    if (node.camera == -1) continue;
    const auto source = entry(document.model.cameras, node.camera, "camera");
    if (!source) return Error{node_name(document.model, nodes[i].node) + ": " + source.error().message};
    if ((*source)->type != "perspective") continue;
    const Result<float> fov = field_of_view(**source);
    if (!fov) return fov.error();
    Result<CameraPath> path = paths.read(i);
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
