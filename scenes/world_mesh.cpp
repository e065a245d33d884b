#include "scenes/world_mesh.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "scenes/world_triangles.h"

namespace gnomon::scenes {
namespace {

constexpr glm::vec3 kUp(0.0f, 1.0f, 0.0f);

glm::vec3 unit_or_up(const glm::vec3& v) {
  const float length = glm::length(v);
  return std::isnormal(length) ? v / length : kUp;
}

// The transform of normals: the cofactor matrix, which is the inverse transpose without its division. The sign for
// mirroring makes it point outwards again.
glm::mat3 normal_transform(const glm::mat4& object_to_world, bool mirrored) {
  const glm::vec3 x(object_to_world[0]);
  const glm::vec3 y(object_to_world[1]);
  const glm::vec3 z(object_to_world[2]);
  const glm::mat3 cofactors(glm::cross(y, z), glm::cross(z, x), glm::cross(x, y));
  return mirrored ? -cofactors : cofactors;
}

class Builder {
 public:
  explicit Builder(WorldMesh& mesh) : mesh_(mesh) {}

  void append(const Placement& placement) {
    if (placement.primitive.normals.empty()) {
      append_flat(placement);
    } else {
      append_smooth(placement);
    }
  }

 private:
  // Each face has its own normal, so that neighbours cannot share vertices.
  void append_flat(const Placement& placement) {
    const Primitive& primitive = placement.primitive;
    const std::vector<glm::vec3> positions = placement.world_positions();
    const bool mirrored = placement.mirrored();
    for (const glm::uvec3& triangle : primitive.triangles) {
      const glm::uvec3 t = wound(triangle, mirrored);
      const glm::vec3 normal = face_normal(positions[t.x], positions[t.y], positions[t.z]);
      if (!has_area(normal)) continue;
      const uint32_t base = vertex_count();
      for (int corner = 0; corner < 3; ++corner) {
        const uint32_t v = t[corner];
        mesh_.positions.push_back(positions[v]);
        mesh_.normals.push_back(unit_or_up(normal));
        mesh_.uvs.push_back(primitive.uvs.empty() ? glm::vec2(0.0f) : primitive.uvs[v]);
      }
      push(glm::uvec3(base, base + 1, base + 2), primitive.material);
    }
  }

  void append_smooth(const Placement& placement) {
    const Primitive& primitive = placement.primitive;
    const std::vector<glm::vec3> positions = placement.world_positions();
    const bool mirrored = placement.mirrored();
    const glm::mat3 to_world = normal_transform(placement.object_to_world, mirrored);
    const uint32_t base = vertex_count();
    mesh_.positions.insert(mesh_.positions.end(), positions.begin(), positions.end());
    for (const glm::vec3& normal : primitive.normals) mesh_.normals.push_back(unit_or_up(to_world * normal));
    if (primitive.uvs.empty()) {
      mesh_.uvs.resize(mesh_.positions.size(), glm::vec2(0.0f));
    } else {
      mesh_.uvs.insert(mesh_.uvs.end(), primitive.uvs.begin(), primitive.uvs.end());
    }
    for (const glm::uvec3& triangle : primitive.triangles) {
      const glm::uvec3 t = wound(triangle, mirrored);
      if (has_area(face_normal(positions[t.x], positions[t.y], positions[t.z]))) push(t + base, primitive.material);
    }
  }

  uint32_t vertex_count() const { return static_cast<uint32_t>(mesh_.positions.size()); }

  void push(const glm::uvec3& triangle, uint32_t material) {
    mesh_.triangles.push_back(triangle);
    mesh_.materials.push_back(material);
  }

  WorldMesh& mesh_;
};

WorldMeshSize size_of(const Scene& scene, std::span<const Instance> instances) {
  WorldMeshSize size;
  for (const Blocking wanted : {Blocking::always, Blocking::by_alpha}) {
    for_each_placement(scene, instances, wanted, [&](const Placement& placement) {
      const Primitive& p = placement.primitive;
      size.vertices += p.normals.empty() ? 3 * p.triangles.size() : p.positions.size();
      size.triangles += p.triangles.size();
    });
  }
  return size;
}

void reserve(const WorldMeshSize& size, WorldMesh& mesh) {
  mesh.positions.reserve(size.vertices);
  mesh.normals.reserve(size.vertices);
  mesh.uvs.reserve(size.vertices);
  mesh.triangles.reserve(size.triangles);
  mesh.materials.reserve(size.triangles);
}

WorldMesh build(const Scene& scene, std::span<const Instance> instances) {
  WorldMesh mesh;
  reserve(size_of(scene, instances), mesh);
  Builder builder(mesh);
  for_each_placement(scene, instances, Blocking::always, [&](const Placement& p) { builder.append(p); });
  mesh.opaque_count = static_cast<uint32_t>(mesh.triangles.size());
  for_each_placement(scene, instances, Blocking::by_alpha, [&](const Placement& p) { builder.append(p); });
  return mesh;
}

float wrapped(float u, Wrap wrap) {
  switch (wrap) {
    case Wrap::clamp_to_edge: return std::clamp(u, 0.0f, 1.0f);
    case Wrap::repeat: return u - std::floor(u);
    case Wrap::mirrored_repeat: break;
  }
  const float within_two = u - 2.0f * std::floor(0.5f * u);
  return within_two > 1.0f ? 2.0f - within_two : within_two;
}

uint32_t texel(float u, Wrap wrap, uint32_t size) {
  return std::min(static_cast<uint32_t>(wrapped(u, wrap) * static_cast<float>(size)), size - 1);
}

}  // namespace

Blocking blocking_of(const Scene& scene, uint32_t material) {
  const Material& m = scene.materials[material];
  if (m.alpha_mode == AlphaMode::opaque) return Blocking::always;
  if (m.alpha_mode == AlphaMode::blend) return Blocking::never;
  if (m.base_color_texture != kNone && scene.textures[m.base_color_texture].has_alpha) return Blocking::by_alpha;
  return m.base_color.a >= m.alpha_cutoff ? Blocking::always : Blocking::never;
}

WorldMesh build_world_mesh(const Scene& scene) { return build(scene, scene.instances); }

WorldMesh build_moving_mesh(const Scene& scene, SceneTime time) {
  return build(scene, moved_instances(scene, time));
}

WorldMeshSize world_mesh_size(const Scene& scene) { return size_of(scene, scene.instances); }

MovingMeshSize moving_mesh_size(const Scene& scene) {
  const WorldMeshSize size = size_of(scene, moved_instances(scene, SceneTime(0)));
  return {static_cast<uint32_t>(size.vertices), static_cast<uint32_t>(size.triangles)};
}

bool passes_alpha_test(const Scene& scene, uint32_t material, glm::vec2 uv) {
  const Material& m = scene.materials[material];
  float alpha = m.base_color.a;
  if (m.base_color_texture != kNone) {
    const Texture& t = scene.textures[m.base_color_texture];
    const size_t x = texel(uv.x, t.wrap_u, t.width);
    const size_t y = texel(uv.y, t.wrap_v, t.height);
    alpha *= static_cast<float>(t.rgba[4 * (y * t.width + x) + 3]) / 255.0f;
  }
  return alpha >= m.alpha_cutoff;
}

}  // namespace gnomon::scenes
