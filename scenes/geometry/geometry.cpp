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

Geometry make_geometry(const Scene& scene) {
  Geometry geometry;
  geometry.mesh = build_world_mesh(scene);
  geometry.clusters = make_clusters(scene, geometry.mesh);
  return geometry;
}

GeometryPtr geometry_of(const Scene& scene) {
  return scene.geometry ? scene.geometry : std::make_shared<const Geometry>(make_geometry(scene));
}

}  // namespace gnomon::scenes
