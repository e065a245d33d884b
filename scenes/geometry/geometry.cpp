#include "scenes/geometry/geometry.h"

namespace gnomon::scenes {
namespace {

template <class T>
uint64_t bytes_of(const std::vector<T>& list) {
  return list.capacity() * sizeof(T);
}

}  // namespace

uint64_t Geometry::memory_bytes() const {
  return sizeof(Geometry) + bytes_of(mesh.positions) + bytes_of(mesh.normals) + bytes_of(mesh.uvs) +
         bytes_of(mesh.triangles) + bytes_of(mesh.materials) + bytes_of(clusters.numbers) +
         bytes_of(clusters.clusters) + bytes_of(clusters.chunks);
}

uint64_t predicted_bytes(const Scene& scene) {
  constexpr uint64_t kVertex = 2 * sizeof(glm::vec3) + sizeof(glm::vec2);
  constexpr uint64_t kTriangle = sizeof(glm::uvec3) + sizeof(uint32_t);
  constexpr uint64_t kClusters =
      sizeof(uint32_t) + sizeof(Cluster) / 8;  // of a triangle; clusters are seldom smaller
  constexpr uint64_t kHierarchy = 48 + 32;     // of a triangle, and of its share of the nodes (gpu/builds/bvh.h)
  const WorldMeshSize size = world_mesh_size(scene);
  const uint64_t geometry = size.vertices * kVertex + size.triangles * (kTriangle + kClusters);
  uint64_t textures = 0;
  for (const Texture& texture : scene.textures) textures += texture.rgba.size();
  const uint64_t host = scene.memory_bytes() + (scene.geometry ? 0 : geometry);
  return host + geometry + textures + size.triangles * kHierarchy;
}

Geometry make_geometry(const Scene& scene, const OnShare& on_share) {
  Geometry geometry;
  geometry.mesh = build_world_mesh(scene);
  geometry.clusters = make_clusters(scene, geometry.mesh, on_share);
  return geometry;
}

GeometryPtr geometry_of(const Scene& scene) {
  return scene.geometry ? scene.geometry : std::make_shared<const Geometry>(make_geometry(scene));
}

}  // namespace gnomon::scenes
