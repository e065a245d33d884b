// The triangles of a scene in the world, in the order that world meshes and content hashes share. Internal to scenes/.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "scenes/scene.h"

namespace gnomon::scenes {

// Whether a surface blocks a shadow segment.
enum class Blocking { always, by_alpha, never };
Blocking blocking_of(const Scene& scene, uint32_t material);

// A primitive and its place in the world.
struct Placement {
  const Primitive& primitive;
  const glm::mat4& object_to_world;

  bool mirrored() const { return glm::determinant(glm::mat3(object_to_world)) < 0.0f; }
  std::vector<glm::vec3> world_positions() const {
    std::vector<glm::vec3> positions(primitive.positions.size());
    for (size_t i = 0; i < positions.size(); ++i) {
      positions[i] = glm::vec3(object_to_world * glm::vec4(primitive.positions[i], 1.0f));
    }
    return positions;
  }
};

// Visits the primitives of those `instances` that do not move whose material blocks in the `wanted` way, in order.
template <class Visit>
void for_each_placement(const Scene& scene, std::span<const Instance> instances, Blocking wanted, Visit visit) {
  for (const Instance& instance : instances) {
    if (instance.moved_by != kNone) continue;
    for (const Primitive& primitive : scene.meshes[instance.mesh].primitives) {
      if (blocking_of(scene, primitive.material) == wanted) visit(Placement{primitive, instance.object_to_world});
    }
  }
}

// Not a unit vector; its length is twice the area.
inline glm::vec3 face_normal(const glm::vec3& p0, const glm::vec3& p1, const glm::vec3& p2) {
  const glm::vec3 a = p1 - p0;
  const glm::vec3 b = p2 - p0;
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

// Whether the tracers, which compute in floats, can normalise the face's normal.
inline bool has_area(const glm::vec3& normal) {
  return std::isnormal(normal.x * normal.x + normal.y * normal.y + normal.z * normal.z);
}

inline glm::uvec3 wound(const glm::uvec3& triangle, bool mirrored) {
  return mirrored ? glm::uvec3(triangle.x, triangle.z, triangle.y) : triangle;
}

}  // namespace gnomon::scenes
