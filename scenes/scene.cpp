#include "scenes/scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/geometry/geometry.h"
#include "scenes/pose.h"

namespace gnomon::scenes {
namespace {

glm::dquat to_quat(const glm::dvec4& xyzw) { return {xyzw.w, xyzw.x, xyzw.y, xyzw.z}; }
glm::dvec4 to_vec4(const glm::dquat& q) { return {q.x, q.y, q.z, q.w}; }

glm::dvec4 between(const Channel& channel, size_t k, double t) {
  const glm::dvec4 from(channel.values[k]), to(channel.values[k + 1]);
  if (channel.interpolation == Interpolation::step) return from;
  if (channel.path == Channel::Path::rotation) {
    return to_vec4(glm::slerp(glm::normalize(to_quat(from)), glm::normalize(to_quat(to)), t));
  }
  return glm::mix(from, to, t);
}

// glTF 2.0, appendix C.5: a Hermite spline whose tangents are given per second.
glm::dvec4 on_spline(const Channel& channel, size_t k, double t, double seconds) {
  const auto& v = channel.values;
  const glm::dvec4 start(v[3 * k + 1]);
  const glm::dvec4 leaving = glm::dvec4(v[3 * k + 2]) * seconds;
  const glm::dvec4 arriving = glm::dvec4(v[3 * (k + 1)]) * seconds;
  const glm::dvec4 end(v[3 * (k + 1) + 1]);
  const double t2 = t * t;
  const double t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * start + (t3 - 2 * t2 + t) * leaving + (3 * t2 - 2 * t3) * end +
         (t3 - t2) * arriving;
}

// Computes in doubles, so that machines whose libraries round differently agree after the conversion to floats.
glm::dvec4 sample(const Channel& channel, double seconds) {
  const auto& times = channel.times;
  const bool spline = channel.interpolation == Interpolation::cubic_spline;
  const auto key = [&](size_t k) { return glm::dvec4(channel.values[spline ? 3 * k + 1 : k]); };
  const auto next = std::upper_bound(times.begin(), times.end(), seconds,
                                     [](double s, float time) { return s < static_cast<double>(time); });
  if (next == times.begin()) return key(0);
  if (next == times.end()) return key(times.size() - 1);
  const size_t k = static_cast<size_t>(next - times.begin()) - 1;
  const double start = static_cast<double>(times[k]);
  const double span = static_cast<double>(times[k + 1]) - start;
  const double t = (seconds - start) / span;
  return spline ? on_spline(channel, k, t, span) : between(channel, k, t);
}

template <class T>
uint64_t bytes_of(const std::vector<T>& v) {
  return v.capacity() * sizeof(T);
}

uint64_t bytes_inside(const Mesh& mesh) {
  uint64_t bytes = bytes_of(mesh.primitives) + mesh.name.capacity();
  for (const Primitive& p : mesh.primitives) {
    bytes += bytes_of(p.positions) + bytes_of(p.normals) + bytes_of(p.uvs) + bytes_of(p.triangles);
  }
  return bytes;
}

uint64_t bytes_inside(const std::vector<Channel>& channels) {
  uint64_t bytes = bytes_of(channels);
  for (const Channel& c : channels) bytes += bytes_of(c.times) + bytes_of(c.values);
  return bytes;
}

glm::dvec3 unit_or(const glm::dvec3& v, const glm::dvec3& otherwise) {
  const double length = glm::length(v);
  return std::isnormal(length) ? v / length : otherwise;
}

// Turns the light's sides along the node's axes; its scale does not change their length.
void turn(const glm::dmat4& node_to_world, LightArea& area) {
  if (area.shape != LightShape::disc && area.shape != LightShape::rectangle) return;
  const double u = glm::length(area.u), v = glm::length(area.v);
  area.u = glm::vec3(u * unit_or(glm::dvec3(node_to_world[0]), {1, 0, 0}));
  area.v = glm::vec3(v * unit_or(glm::dvec3(node_to_world[1]), {0, 1, 0}));
}

}  // namespace

void apply(const Channel& channel, double seconds, NodeTransform& node) {
  const glm::dvec4 value = sample(channel, seconds);
  switch (channel.path) {
    case Channel::Path::translation: node.translation = glm::vec3(value); break;
    case Channel::Path::scale: node.scale = glm::vec3(value); break;
    case Channel::Path::rotation: node.rotation = glm::quat(to_quat(value)); break;
  }
}

glm::dmat4 local_transform(const NodeTransform& node) {
  if (node.has_matrix) return glm::dmat4(node.matrix);
  const float length = glm::length(node.rotation);
  const glm::dquat rotation = std::isnormal(length) ? glm::dquat(node.rotation / length) : glm::dquat(1, 0, 0, 0);
  const glm::dmat4 placed = glm::translate(glm::dmat4(1.0), glm::dvec3(node.translation));
  return glm::scale(placed * glm::mat4_cast(rotation), glm::dvec3(node.scale));
}

bool place_light(const glm::dmat4& node_to_world, Light& light) {
  light.position = glm::vec3(node_to_world[3]);
  turn(node_to_world, light.area);
  const glm::dvec3 forward(-node_to_world[2]);
  const double length = glm::length(forward);
  if (!std::isnormal(length)) return false;
  light.direction = glm::normalize(glm::vec3(forward / length));
  return true;
}

CameraPose pose_from_transform(const glm::dmat4& camera_to_world, float vertical_fov) {
  const glm::dvec3 back = unit_or(glm::dvec3(camera_to_world[2]), {0, 0, 1});
  const glm::dvec3 up = unit_or(glm::dvec3(camera_to_world[1]), {0, 1, 0});
  const glm::dvec3 aside = std::abs(back.x) < 0.9 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
  const glm::dvec3 right = unit_or(glm::cross(up, back), unit_or(aside - glm::dot(aside, back) * back, {1, 0, 0}));
  const glm::dmat3 axes(right, glm::cross(back, right), back);
  CameraPose pose;
  pose.position = glm::vec3(camera_to_world[3]);
  pose.orientation = glm::quat(glm::normalize(glm::quat_cast(axes)));
  pose.vertical_fov = vertical_fov;
  return pose;
}

CameraPose pose_at(const CameraPath& path, float vertical_fov, float seconds) {
  const float when = std::isfinite(seconds) ? std::clamp(seconds, 0.0f, path.duration_seconds) : 0.0f;
  std::vector<NodeTransform> chain = path.chain;
  for (const Channel& channel : path.channels) apply(channel, static_cast<double>(when), chain[channel.node]);
  glm::dmat4 camera_to_world(1.0);
  for (const NodeTransform& node : chain) camera_to_world = camera_to_world * local_transform(node);
  return pose_from_transform(camera_to_world, vertical_fov);
}

std::string to_hex(const ContentHash& hash) {
  constexpr char kDigits[] = "0123456789abcdef";
  std::string text;
  for (const uint8_t byte : hash) {
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

uint64_t Scene::memory_bytes() const {
  uint64_t bytes = sizeof(Scene) + bytes_of(textures) + bytes_of(materials) + bytes_of(meshes) +
                   bytes_of(instances) + bytes_of(lights) + bytes_of(cameras) + bytes_of(paths) +
                   bytes_of(moving_nodes);
  for (const Texture& texture : textures) bytes += bytes_of(texture.rgba) + bytes_of(texture.encoded);
  for (const Mesh& mesh : meshes) bytes += bytes_inside(mesh);
  for (const CameraPath& path : paths) bytes += bytes_of(path.chain) + bytes_inside(path.channels);
  for (const MovingNode& node : moving_nodes) bytes += bytes_inside(node.channels);
  if (geometry) bytes += geometry->memory_bytes();
  return bytes;
}

}  // namespace gnomon::scenes
