#include "gpu/wire/translate.h"

#include <cmath>

namespace gnomon::gpu {
namespace {

protocol::Vec3 to_wire(glm::vec3 v) { return {v.x, v.y, v.z}; }

glm::vec3 from_wire(const protocol::Vec3& v) { return {v[0], v[1], v[2]}; }

protocol::LightKind to_wire(scenes::LightType type) {
  switch (type) {
    case scenes::LightType::point: return protocol::LightKind::point;
    case scenes::LightType::spot: return protocol::LightKind::spot;
    case scenes::LightType::directional: return protocol::LightKind::directional;
  }
  return protocol::LightKind::point;
}

scenes::LightType from_wire(protocol::LightKind kind) {
  switch (kind) {
    case protocol::LightKind::point: return scenes::LightType::point;
    case protocol::LightKind::spot: return scenes::LightType::spot;
    case protocol::LightKind::directional: return scenes::LightType::directional;
  }
  return scenes::LightType::point;
}

protocol::LightInfo to_wire(const scenes::Light& light) {
  protocol::LightInfo info;
  info.kind = to_wire(light.type);
  info.position = to_wire(light.position);
  info.direction = to_wire(light.direction);
  info.color = to_wire(light.color);
  info.intensity = light.intensity;
  info.range = light.range;
  info.inner_cone_cos = light.inner_cone_cos;
  info.outer_cone_cos = light.outer_cone_cos;
  return info;
}

protocol::CameraView to_wire(const scenes::CameraPose& pose, float aspect) {
  protocol::CameraView view;
  view.position = to_wire(pose.position);
  view.orientation = {pose.orientation.x, pose.orientation.y, pose.orientation.z, pose.orientation.w};
  view.tan_up = view.tan_down = std::tan(pose.vertical_fov / 2);
  view.tan_left = view.tan_right = view.tan_up * aspect;
  return view;
}

}  // namespace

CameraView from_wire(const protocol::CameraView& camera) {
  const auto& q = camera.orientation;
  return {.position = from_wire(camera.position),
          .orientation = glm::quat(q[3], q[0], q[1], q[2]),  // glm takes w first
          .tan_left = camera.tan_left,
          .tan_right = camera.tan_right,
          .tan_up = camera.tan_up,
          .tan_down = camera.tan_down,
          .near_plane = camera.near_plane};
}

protocol::CameraView to_wire(const CameraView& camera) {
  const glm::quat& q = camera.orientation;
  return {.position = to_wire(camera.position),
          .orientation = {q.x, q.y, q.z, q.w},
          .tan_left = camera.tan_left,
          .tan_right = camera.tan_right,
          .tan_up = camera.tan_up,
          .tan_down = camera.tan_down,
          .near_plane = camera.near_plane};
}

scenes::Light from_wire(const protocol::LightInfo& info) {
  scenes::Light light;
  light.type = from_wire(info.kind);
  light.position = from_wire(info.position);
  light.direction = from_wire(info.direction);
  light.color = from_wire(info.color);
  light.intensity = info.intensity;
  light.range = info.range;
  light.inner_cone_cos = info.inner_cone_cos;
  light.outer_cone_cos = info.outer_cone_cos;
  return light;
}

std::vector<protocol::LightInfo> to_wire(const std::vector<scenes::Light>& lights) {
  std::vector<protocol::LightInfo> out;
  for (const scenes::Light& light : lights) out.push_back(to_wire(light));
  return out;
}

// The wire numbers shapes as scenes do.
std::vector<protocol::AreaInfo> areas_to_wire(const std::vector<scenes::Light>& lights) {
  static_assert(static_cast<uint8_t>(scenes::LightShape::rectangle) == 3);
  std::vector<protocol::AreaInfo> out;
  for (const scenes::Light& light : lights) {
    out.push_back({static_cast<uint8_t>(light.area.shape), to_wire(light.area.u), to_wire(light.area.v)});
  }
  return out;
}

std::vector<protocol::NodeMotion> to_wire(const std::vector<scenes::NodeMotion>& motions) {
  std::vector<protocol::NodeMotion> out;
  for (const scenes::NodeMotion& m : motions) {
    out.push_back(
        {m.node, static_cast<uint8_t>(m.kind), to_wire(m.vector), static_cast<uint32_t>(m.period.count())});
  }
  return out;
}

protocol::SceneManifest manifest_of(const scenes::Scene& scene, const std::string& name, float aspect) {
  protocol::SceneManifest manifest;
  manifest.name = name;
  manifest.content_hash = scene.content_hash;
  manifest.triangles = scene.triangle_count;
  manifest.bounds_min = to_wire(scene.bounds.min);
  manifest.bounds_max = to_wire(scene.bounds.max);
  manifest.default_camera = to_wire(scene.cameras.front().rest, aspect);
  manifest.lights = to_wire(scene.lights);
  return manifest;
}

}  // namespace gnomon::gpu
