#include "scenes/scene.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/pose.h"

namespace gnomon::scenes {
namespace {

glm::quat to_quat(const glm::vec4& xyzw) { return {xyzw.w, xyzw.x, xyzw.y, xyzw.z}; }
glm::vec4 to_vec4(const glm::quat& q) { return {q.x, q.y, q.z, q.w}; }

glm::vec4 between(const Channel& channel, size_t k, float t) {
  const auto& v = channel.values;
  if (channel.interpolation == Interpolation::step) return v[k];
  if (channel.path == Channel::Path::rotation) {
    return to_vec4(glm::slerp(glm::normalize(to_quat(v[k])), glm::normalize(to_quat(v[k + 1])), t));
  }
  return glm::mix(v[k], v[k + 1], t);
}

// glTF 2.0, appendix C.5: a Hermite spline whose tangents are given per second.
glm::vec4 on_spline(const Channel& channel, size_t k, float t, float seconds) {
  const auto& v = channel.values;
  const glm::vec4 start = v[3 * k + 1];
  const glm::vec4 leaving = v[3 * k + 2] * seconds;
  const glm::vec4 arriving = v[3 * (k + 1)] * seconds;
  const glm::vec4 end = v[3 * (k + 1) + 1];
  const float t2 = t * t;
  const float t3 = t2 * t;
  return (2 * t3 - 3 * t2 + 1) * start + (t3 - 2 * t2 + t) * leaving + (3 * t2 - 2 * t3) * end +
         (t3 - t2) * arriving;
}

glm::vec4 sample(const Channel& channel, float seconds) {
  const auto& times = channel.times;
  const bool spline = channel.interpolation == Interpolation::cubic_spline;
  const auto key = [&](size_t k) { return channel.values[spline ? 3 * k + 1 : k]; };
  const auto next = std::upper_bound(times.begin(), times.end(), seconds);
  if (next == times.begin()) return key(0);
  if (next == times.end()) return key(times.size() - 1);
  const size_t k = static_cast<size_t>(next - times.begin()) - 1;
  const float span = times[k + 1] - times[k];
  const float t = (seconds - times[k]) / span;
  return spline ? on_spline(channel, k, t, span) : between(channel, k, t);
}

void apply(const Channel& channel, float seconds, NodeTransform& node) {
  const glm::vec4 value = sample(channel, seconds);
  switch (channel.path) {
    case Channel::Path::translation: node.translation = glm::vec3(value); break;
    case Channel::Path::scale: node.scale = glm::vec3(value); break;
    case Channel::Path::rotation: node.rotation = to_quat(value); break;
  }
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

uint64_t bytes_inside(const CameraPath& path) {
  uint64_t bytes = bytes_of(path.chain) + bytes_of(path.channels);
  for (const Channel& c : path.channels) bytes += bytes_of(c.times) + bytes_of(c.values);
  return bytes;
}

glm::dvec3 unit_or(const glm::dvec3& v, const glm::dvec3& otherwise) {
  const double length = glm::length(v);
  return std::isnormal(length) ? v / length : otherwise;
}

}  // namespace

glm::dmat4 local_transform(const NodeTransform& node) {
  if (node.has_matrix) return glm::dmat4(node.matrix);
  const float length = glm::length(node.rotation);
  const glm::dquat rotation = std::isnormal(length) ? glm::dquat(node.rotation / length) : glm::dquat(1, 0, 0, 0);
  const glm::dmat4 placed = glm::translate(glm::dmat4(1.0), glm::dvec3(node.translation));
  return glm::scale(placed * glm::mat4_cast(rotation), glm::dvec3(node.scale));
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
  for (const Channel& channel : path.channels) apply(channel, when, chain[channel.node]);
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
                   bytes_of(instances) + bytes_of(lights) + bytes_of(cameras) + bytes_of(paths);
  for (const Texture& texture : textures) bytes += bytes_of(texture.rgba);
  for (const Mesh& mesh : meshes) bytes += bytes_inside(mesh);
  for (const CameraPath& path : paths) bytes += bytes_inside(path);
  return bytes;
}

}  // namespace gnomon::scenes
