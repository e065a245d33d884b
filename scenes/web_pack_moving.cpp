#include "scenes/web_pack_moving.h"

#include <cmath>

#include "scenes/world_triangles.h"

namespace gnomon::scenes {
namespace {

void append_flat(const Primitive& primitive, WorldMesh& mesh) {
  for (const glm::uvec3& t : primitive.triangles) {
    const auto base = static_cast<uint32_t>(mesh.positions.size());
    const glm::vec3 normal =
        face_normal(primitive.positions[t.x], primitive.positions[t.y], primitive.positions[t.z]);
    for (int corner = 0; corner < 3; ++corner) {
      mesh.positions.push_back(primitive.positions[t[corner]]);
      mesh.normals.push_back(has_area(normal) ? glm::normalize(normal) : glm::vec3(0.0f, 1.0f, 0.0f));
      mesh.uvs.push_back(primitive.uvs.empty() ? glm::vec2(0.0f) : primitive.uvs[t[corner]]);
    }
    mesh.triangles.push_back({base, base + 1, base + 2});
  }
}

void append_smooth(const Primitive& primitive, WorldMesh& mesh) {
  const auto base = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), primitive.positions.begin(), primitive.positions.end());
  mesh.normals.insert(mesh.normals.end(), primitive.normals.begin(), primitive.normals.end());
  mesh.uvs.insert(mesh.uvs.end(), primitive.uvs.begin(), primitive.uvs.end());
  mesh.uvs.resize(mesh.positions.size(), glm::vec2(0.0f));
  for (const glm::uvec3& t : primitive.triangles) mesh.triangles.push_back(t + base);
}

void extend_groups(const MovingInstance& added, bool masked, bool double_sided, std::vector<ClusterGroup>& groups) {
  if (groups.empty() || groups.back().masked != masked || groups.back().double_sided != double_sided) {
    groups.push_back({});
    groups.back().first_triangle = added.first_triangle;
    groups.back().masked = masked;
    groups.back().double_sided = double_sided;
  }
  groups.back().triangle_count += added.triangles;
}

}  // namespace

MovingPart moving_part(const Scene& scene) {
  MovingPart part;
  WorldMesh& mesh = part.mesh;
  for (const Blocking wanted : {Blocking::always, Blocking::by_alpha}) {
    for (const Instance& instance : scene.instances) {
      if (instance.moved_by == kNone) continue;
      for (const Primitive& primitive : scene.meshes[instance.mesh].primitives) {
        if (blocking_of(scene, primitive.material) != wanted) continue;
        MovingInstance added;
        added.node = instance.moved_by;
        added.first_vertex = static_cast<uint32_t>(mesh.positions.size());
        added.first_triangle = static_cast<uint32_t>(mesh.triangles.size());
        added.flat = primitive.normals.empty();
        added.flat ? append_flat(primitive, mesh) : append_smooth(primitive, mesh);
        added.vertices = static_cast<uint32_t>(mesh.positions.size()) - added.first_vertex;
        added.triangles = static_cast<uint32_t>(mesh.triangles.size()) - added.first_triangle;
        mesh.materials.resize(mesh.triangles.size(), primitive.material);
        extend_groups(added, wanted == Blocking::by_alpha, scene.materials[primitive.material].double_sided,
                      part.groups);
        part.instances.push_back(added);
      }
    }
    if (wanted == Blocking::always) mesh.opaque_count = static_cast<uint32_t>(mesh.triangles.size());
  }
  return part;
}

}  // namespace gnomon::scenes
