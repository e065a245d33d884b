#include "tests/unit/scenes/support/invariants.h"

#include <algorithm>
#include <cmath>

#include "scenes/world_mesh.h"

namespace gnomon::scenes::testing {
namespace {

bool finite(float v) { return std::isfinite(v); }
bool finite(const glm::vec3& v) { return finite(v.x) && finite(v.y) && finite(v.z); }
bool unit(const glm::vec3& v) { return std::abs(glm::length(v) - 1.0f) < 1e-4f; }

std::string broken(const Scene& scene, const Primitive& p) {
  const auto in_range = [&](const glm::uvec3& t) {
    return t.x < p.positions.size() && t.y < p.positions.size() && t.z < p.positions.size();
  };
  if (p.material >= scene.materials.size()) return "a material index is out of range";
  if (!std::all_of(p.triangles.begin(), p.triangles.end(), in_range)) return "a vertex index is out of range";
  for (const glm::vec3& v : p.positions) {
    if (!finite(v)) return "a position is not finite";
  }
  if (!p.normals.empty() && p.normals.size() != p.positions.size()) return "normals are not one for each position";
  if (!std::all_of(p.normals.begin(), p.normals.end(), unit)) return "a normal is not unit";
  if (!p.uvs.empty() && p.uvs.size() != p.positions.size()) return "uvs are not one for each position";
  return "";
}

std::string broken(const Light& light) {
  if (!finite(light.position) || !finite(light.color) || !finite(light.intensity)) return "a light is not finite";
  if (!unit(light.direction)) return "a light's direction is not unit";
  if (!(light.outer_cone_cos >= 0.0f && light.outer_cone_cos <= light.inner_cone_cos))
    return "a cone is inside out";
  return light.range >= 0.0f ? "" : "a range is negative";
}

std::string broken(const CameraPose& pose) {
  const bool whole = finite(pose.position) && std::abs(glm::length(pose.orientation) - 1.0f) < 1e-4f;
  return whole && pose.vertical_fov > 0.0f ? "" : "a camera pose is not valid";
}

std::string broken(const Scene& scene, const WorldMesh& mesh) {
  const size_t vertices = mesh.positions.size();
  if (mesh.normals.size() != vertices || mesh.uvs.size() != vertices) return "world vertices lack attributes";
  if (mesh.materials.size() != mesh.triangles.size()) return "world triangles lack materials";
  if (mesh.opaque_count > mesh.triangles.size()) return "the opaque count is too large";
  for (const glm::uvec3& t : mesh.triangles) {
    if (t.x >= vertices || t.y >= vertices || t.z >= vertices) return "a world vertex index is out of range";
  }
  for (size_t i = mesh.opaque_count; i < mesh.triangles.size(); ++i) {
    passes_alpha_test(scene, mesh.materials[i], mesh.uvs[mesh.triangles[i].x]);
  }
  return std::all_of(mesh.normals.begin(), mesh.normals.end(), unit) ? "" : "a world normal is not unit";
}

}  // namespace

std::string broken_promise(const Scene& scene) {
  if (scene.materials.empty()) return "there is no material";
  if (scene.cameras.empty()) return "there is no camera";
  for (const Material& m : scene.materials) {
    if (m.base_color_texture != kNone && m.base_color_texture >= scene.textures.size())
      return "a texture is missing";
  }
  for (const Texture& t : scene.textures) {
    const bool left_out = t.rgba.empty() && !t.encoded.empty();
    if (t.width == 0 || (!left_out && t.rgba.size() != size_t{4} * t.width * t.height))
      return "a texture's size is wrong";
  }
  std::string found;
  const auto check = [&](std::string what) { found = found.empty() ? std::move(what) : found; };
  for (const Mesh& mesh : scene.meshes) {
    for (const Primitive& primitive : mesh.primitives) check(broken(scene, primitive));
  }
  for (const Instance& i : scene.instances) check(i.mesh < scene.meshes.size() ? "" : "an instance has no mesh");
  for (const Light& light : scene.lights) check(broken(light));
  for (const Camera& camera : scene.cameras) check(broken(camera.rest));
  for (const CameraPath& path : scene.paths) {
    check(path.camera < scene.cameras.size() ? "" : "a path has no camera");
    for (const float t : {-1.0f, 0.0f, 0.3f * path.duration_seconds, path.duration_seconds + 1.0f}) {
      check(broken(pose_at(path, 1.0f, t)));
    }
  }
  for (const Instance& i : scene.instances) {
    check(i.moved_by == kNone || i.moved_by < scene.moving_nodes.size() ? "" : "an instance's node is missing");
  }
  for (uint32_t i = 0; i < scene.moving_nodes.size(); ++i) {
    const uint32_t parent = scene.moving_nodes[i].parent;
    check(parent == kNone || parent < i ? "" : "a moving node comes before its parent");
  }
  check(broken(orbit_pose(scene, 3.0f)));
  check(finite(scene.bounds.min) && finite(scene.bounds.max) ? "" : "the bounds are not finite");
  if (found.empty()) check(broken(scene, build_world_mesh(scene)));
  if (found.empty() && moves(scene)) {
    check(broken(scene, build_moving_mesh(scene, scene.period / 3)));
    for (const Light& light : lights_at(scene, scene.lights, scene.period / 3)) check(broken(light));
  }
  return found;
}

}  // namespace gnomon::scenes::testing
