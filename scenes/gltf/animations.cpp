#include "scenes/gltf/animations.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <optional>
#include <string>
#include <utility>

#include "common/suggestion.h"
#include "scenes/gltf/accessor.h"

namespace gnomon::scenes::gltf {
namespace {

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
  if (const auto ok = document.budget.spend(elements->count(), sizeof(float)); !ok) return ok.error();
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
  if (const auto ok = document.budget.spend(elements->count(), sizeof(glm::vec4)); !ok) return ok.error();
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

constexpr double kMostRepeats = 1000;

double seconds_of(std::chrono::microseconds time) { return std::chrono::duration<double>(time).count(); }

// Replaces the node's channel of the property that the motion moves by one whose keys reach `until` seconds or more. Error:
// it has more keys than a file of that size may ask for.
Result<void> set_motion(const NodeMotion& motion, double until, MovingNode& node, Budget& budget) {
  const bool spins = motion.kind == NodeMotion::Kind::spin;
  Channel channel;
  channel.path = spins ? Channel::Path::rotation : Channel::Path::translation;
  const double step = seconds_of(motion.period) / (spins ? 4 : 2);
  const auto granted =
      budget.spend(static_cast<uint64_t>(until / step) + 2, sizeof channel.times[0] + sizeof channel.values[0]);
  if (!granted) return granted;
  for (int key = 0; key == 0 || static_cast<double>(key - 1) * step < until; ++key) {
    channel.times.push_back(static_cast<float>(static_cast<double>(key) * step));
    if (spins) {
      const auto angle = static_cast<float>(key % 4) * glm::half_pi<float>();
      const glm::quat turned = node.local.rotation * glm::angleAxis(angle, glm::normalize(motion.vector));
      channel.values.emplace_back(turned.x, turned.y, turned.z, turned.w);
    } else {
      channel.values.emplace_back(node.local.translation + (key % 2 ? motion.vector : glm::vec3(0.0f)), 0.0f);
    }
  }
  std::erase_if(node.channels, [&](const Channel& c) { return c.path == channel.path; });
  node.channels.push_back(std::move(channel));
  return {};
}

// The same by translation, rotation and scale, which a motion may change; nullopt of a matrix that has no such form, as it
// is skewed or flat.
std::optional<NodeTransform> in_parts(const NodeTransform& local) {
  if (!local.has_matrix) return local;
  NodeTransform parts;
  parts.translation = glm::vec3(local.matrix[3]);
  glm::mat3 turned(local.matrix);
  for (int i = 0; i < 3; ++i) parts.scale[i] = glm::length(turned[i]);
  if (glm::determinant(turned) < 0) parts.scale.x = -parts.scale.x;
  if (glm::min(std::abs(parts.scale.x), std::min(parts.scale.y, parts.scale.z)) < 1e-6f) return std::nullopt;
  for (int i = 0; i < 3; ++i) turned[i] /= parts.scale[i];
  const float skew = std::max({std::abs(glm::dot(turned[0], turned[1])), std::abs(glm::dot(turned[1], turned[2])),
                               std::abs(glm::dot(turned[2], turned[0]))});
  if (!(skew < 1e-4f)) return std::nullopt;
  parts.rotation = glm::normalize(glm::quat_cast(turned));
  return parts;
}

// Why the motion of that name moves nothing.
std::string why_it_rests(const tinygltf::Model& model, const std::string& name) {
  std::vector<std::string> names;
  for (const tinygltf::Node& node : model.nodes) names.push_back(node.name);
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    const auto meant = suggestion(name, names);
    return "no node is named '" + name + "'" + (meant ? "; did you mean '" + *meant + "'?" : "");
  }
  return "node '" + name +
         "' cannot move anything: it carries neither a mesh nor a light, or its matrix is skewed or flat";
}

}  // namespace

Animations::Animations(const Document& document) : document_(document) {
  for (const tinygltf::Animation& animation : document.model.animations) {
    for (const tinygltf::AnimationChannel& channel : animation.channels) {
      if (path_of(channel.target_path)) by_node_[channel.target_node].push_back({&animation, &channel});
    }
  }
}

bool Animations::move(const PlacedNode& node) const {
  return !node.local.has_matrix && by_node_.contains(node.node);
}

Result<std::vector<Channel>> Animations::of(const PlacedNode& node) {
  std::vector<Channel> channels;
  if (!move(node)) return channels;
  std::array<bool, 3> taken{};
  for (const Source& source : by_node_.at(node.node)) {
    const Channel::Path property = *path_of(source.channel->target_path);
    if (std::exchange(taken[static_cast<size_t>(property)], true)) continue;
    Result<Channel> channel = read_channel(document_, *source.animation, source.channel->sampler, property);
    if (!channel) return Error{"animation '" + source.animation->name + "' " + channel.error().message};
    channels.push_back(std::move(*channel));
  }
  return channels;
}

MovingNodes::MovingNodes(const tinygltf::Model& model, const std::vector<PlacedNode>& placed,
                         Animations& animations, const std::vector<NodeMotion>& motions)
    : model_(model), placed_(placed), animations_(animations), index_(placed.size(), kNone), motions_(motions) {
  for (const PlacedNode& node : placed) {
    const bool itself = animations.move(node) || is_given_motion(node);
    moved_.push_back(itself || (node.parent != kNone && moved_[node.parent]));
  }
}

bool MovingNodes::is_given_motion(const PlacedNode& node) const {
  const std::string& name = model_.nodes[static_cast<size_t>(node.node)].name;
  const bool given =
      std::any_of(motions_.begin(), motions_.end(), [&](const NodeMotion& m) { return m.node == name; });
  return given && in_parts(node.local);
}

Result<std::chrono::microseconds> MovingNodes::fill_period() {
  for (const NodeMotion& motion : motions_) {
    const bool moves_something =
        std::any_of(given_.begin(), given_.end(), [&](const Given& given) { return given.motion == &motion; });
    if (!moves_something) return Error{"moving: " + why_it_rests(model_, motion.node)};
  }
  const std::chrono::microseconds period = longest();
  const double until = seconds_of(period);
  for (const Given& given : given_) {
    if (until / seconds_of(given.motion->period) > kMostRepeats) {
      return Error{"the motion of node '" + given.motion->node + "' is too fast beside the longest animation"};
    }
    if (auto set = set_motion(*given.motion, until, nodes_[given.node], animations_.budget()); !set)
      return set.error();
  }
  return period;
}

Result<uint32_t> MovingNodes::find(uint32_t placed) {
  if (!moved_[placed]) return kNone;
  if (index_[placed] != kNone) return index_[placed];
  const PlacedNode& source = placed_[placed];
  MovingNode node;
  node.local = source.local;
  if (source.parent != kNone) {
    const Result<uint32_t> parent = find(source.parent);
    if (!parent) return parent;
    node.parent = *parent;
    if (*parent == kNone) node.parent_to_world = placed_[source.parent].to_world;
  }
  auto channels = animations_.of(source);
  if (!channels) return channels.error();
  node.channels = std::move(*channels);
  if (is_given_motion(source)) {
    node.local = *in_parts(source.local);
    for (const NodeMotion& motion : motions_) {
      if (motion.node != model_.nodes[static_cast<size_t>(source.node)].name) continue;
      given_.push_back({static_cast<uint32_t>(nodes_.size()), &motion});
      if (auto set = set_motion(motion, seconds_of(motion.period), node, animations_.budget()); !set)
        return set.error();
    }
  }
  index_[placed] = static_cast<uint32_t>(nodes_.size());
  nodes_.push_back(std::move(node));
  return index_[placed];
}

std::chrono::microseconds MovingNodes::longest() const {
  double seconds = 0;
  for (const MovingNode& node : nodes_) {
    for (const Channel& channel : node.channels)
      seconds = std::max(seconds, static_cast<double>(channel.times.back()));
  }
  constexpr double kLongest = std::numeric_limits<uint32_t>::max();  // the most that the protocol can express
  return std::chrono::microseconds(std::llround(std::min(seconds * 1e6, kLongest)));
}

}  // namespace gnomon::scenes::gltf
