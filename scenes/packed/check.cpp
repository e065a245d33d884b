#include "scenes/packed/check.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <string>

#include "scenes/geometry/geometry.h"

namespace gnomon::scenes {
namespace {

bool finite(float value) { return std::isfinite(value); }

template <glm::length_t N, class T>
bool finite(const glm::vec<N, T>& v) {
  for (glm::length_t i = 0; i < N; ++i) {
    if (!std::isfinite(v[i])) return false;
  }
  return true;
}

template <class T>
bool finite(const glm::mat<4, 4, T>& m) {
  return finite(m[0]) && finite(m[1]) && finite(m[2]) && finite(m[3]);
}

bool finite(const glm::quat& q) { return finite(glm::vec4(q.x, q.y, q.z, q.w)); }

template <class T>
bool all_finite(const std::vector<T>& values) {
  return std::all_of(values.begin(), values.end(), [](const T& value) { return finite(value); });
}

bool is_index(uint32_t index, size_t size) { return index < size; }
bool is_index_or_none(uint32_t index, size_t size) { return index == kNone || index < size; }

bool sound(const Texture& t) {
  const bool left_out = t.rgba.empty() && !t.encoded.empty() && !t.has_alpha;
  return left_out || t.rgba.size() == uint64_t{4} * t.width * t.height;
}

// Whether all textures together have no more texels than that, and each of them has some. Sides may be any numbers, whose
// products do not fit 64 bits.
bool have_texels_within(const std::vector<Texture>& textures, uint64_t most) {
  for (const Texture& t : textures) {
    if (t.width == 0 || t.height == 0 || t.width > most / t.height) return false;
    most -= uint64_t{t.width} * t.height;
  }
  return true;
}

bool sound(const Material& m, const Scene& scene) {
  return finite(m.base_color) && finite(m.emissive) && finite(m.alpha_cutoff) &&
         is_index_or_none(m.base_color_texture, scene.textures.size());
}

bool sound(const Surroundings& s) {
  return finite(s.ambient_above) && finite(s.ambient_below) && finite(s.sky_zenith) && finite(s.sky_horizon) &&
         finite(s.sky_ground) && finite(s.sky_clouds) && finite(s.ambient_reach) && s.ambient_reach >= 0.0f;
}

bool sound(const Primitive& p, const Scene& scene) {
  const size_t vertices = p.positions.size();
  const auto fits = [&](size_t size) { return size == 0 || size == vertices; };
  const auto in_range = [&](const glm::uvec3& t) { return t.x < vertices && t.y < vertices && t.z < vertices; };
  return vertices > 0 && is_index(p.material, scene.materials.size()) && fits(p.normals.size()) &&
         fits(p.uvs.size()) && all_finite(p.positions) && all_finite(p.normals) && all_finite(p.uvs) &&
         std::all_of(p.triangles.begin(), p.triangles.end(), in_range);
}

bool sound(const Mesh& m, const Scene& scene) {
  return !m.primitives.empty() &&
         std::all_of(m.primitives.begin(), m.primitives.end(), [&](const Primitive& p) { return sound(p, scene); });
}

bool sound(const Instance& i, const Scene& scene) {
  return is_index(i.mesh, scene.meshes.size()) && finite(i.object_to_world) &&
         is_index_or_none(i.moved_by, scene.moving_nodes.size());
}

bool sound(const Light& l, const Scene& scene) {
  return finite(l.position) && finite(l.direction) && finite(l.color) && finite(l.intensity) && finite(l.range) &&
         finite(l.inner_cone_cos) && finite(l.outer_cone_cos) && finite(l.area.u) && finite(l.area.v) &&
         is_index_or_none(l.moved_by, scene.moving_nodes.size());
}

bool sound(const Camera& c) {
  return finite(c.rest.position) && finite(c.rest.orientation) && c.rest.vertical_fov > 0 &&
         c.rest.vertical_fov < 3.15f;
}

bool sound(const Channel& c) {
  const size_t values = (c.interpolation == Interpolation::cubic_spline ? 3 : 1) * c.times.size();
  return !c.times.empty() && c.values.size() == values && all_finite(c.times) && all_finite(c.values) &&
         std::adjacent_find(c.times.begin(), c.times.end(), std::greater_equal<>()) == c.times.end();
}

bool sound(const NodeTransform& t) {
  return finite(t.translation) && finite(t.rotation) && finite(t.scale) && finite(t.matrix);
}

bool sound(const std::vector<Channel>& channels) {
  return std::all_of(channels.begin(), channels.end(), [](const Channel& c) { return sound(c); });
}

bool sound(const CameraPath& p, const Scene& scene) {
  return is_index(p.camera, scene.cameras.size()) && finite(p.duration_seconds) && p.duration_seconds >= 0 &&
         std::all_of(p.chain.begin(), p.chain.end(), [](const NodeTransform& t) { return sound(t); }) &&
         sound(p.channels) && std::all_of(p.channels.begin(), p.channels.end(), [&](const Channel& c) {
           return is_index(c.node, p.chain.size());
         });
}

bool sound(const MovingNode& n, size_t number) {
  return is_index_or_none(n.parent, number) && finite(n.parent_to_world) && sound(n.local) && sound(n.channels);
}

// Whether [first, first + count) lies within `size` elements.
bool is_range(uint32_t first, uint32_t count, size_t size) { return first <= size && count <= size - first; }

bool sound(const WorldMesh& mesh, const Scene& scene) {
  const size_t vertices = mesh.positions.size();
  const auto in_range = [&](const glm::uvec3& t) { return t.x < vertices && t.y < vertices && t.z < vertices; };
  const auto is_material = [&](uint32_t m) { return m < scene.materials.size(); };
  return mesh.normals.size() == vertices && mesh.uvs.size() == vertices && all_finite(mesh.positions) &&
         all_finite(mesh.normals) && all_finite(mesh.uvs) && mesh.triangles.size() <= scene.triangle_count &&
         mesh.materials.size() == mesh.triangles.size() && mesh.opaque_count <= mesh.triangles.size() &&
         std::all_of(mesh.triangles.begin(), mesh.triangles.end(), in_range) &&
         std::all_of(mesh.materials.begin(), mesh.materials.end(), is_material);
}

bool sound(const Clusters& c, const WorldMesh& mesh) {
  const size_t triangles = mesh.triangles.size();
  const auto is_number = [&](uint32_t n) { return n < triangles; };
  const auto is_cluster = [&](const Cluster& k) {
    return k.triangle_count <= kMaxTrianglesInCluster && is_range(k.first_triangle, k.triangle_count, triangles);
  };
  const auto is_chunk = [&](const ClusterChunk& k) {
    return k.cluster_count <= kMaxClustersInChunk && is_range(k.first_cluster, k.cluster_count, c.clusters.size());
  };
  const auto is_group = [&](const ClusterGroup& g) {
    return is_range(g.first_triangle, g.triangle_count, triangles) &&
           is_range(g.first_chunk, g.chunk_count, c.chunks.size());
  };
  return c.numbers.size() == triangles && std::all_of(c.numbers.begin(), c.numbers.end(), is_number) &&
         std::all_of(c.clusters.begin(), c.clusters.end(), is_cluster) &&
         std::all_of(c.chunks.begin(), c.chunks.end(), is_chunk) &&
         std::all_of(c.occluders.begin(), c.occluders.end(), is_group) &&
         std::all_of(c.others.begin(), c.others.end(), is_group);
}

// The triangles in the world, or nullopt if they are more than `most`. Precondition: the instances' meshes exist.
std::optional<uint64_t> triangles(const Scene& scene, uint64_t most) {
  std::vector<uint64_t> of_mesh;
  for (const Mesh& mesh : scene.meshes) {
    uint64_t& count = of_mesh.emplace_back(0);
    for (const Primitive& p : mesh.primitives) count += p.triangles.size();
  }
  uint64_t sum = 0;
  for (const Instance& instance : scene.instances) {
    sum += of_mesh[instance.mesh];
    if (sum > most) return std::nullopt;
  }
  return sum;
}

template <class List, class... More>
bool all_sound(const List& list, const More&... more) {
  return std::all_of(list.begin(), list.end(), [&](const auto& element) { return sound(element, more...); });
}

}  // namespace

Result<void> check(const Scene& scene, const LoadLimits& limits) {
  const auto broken = [](const char* what) { return Error{std::string("its ") + what + " are broken"}; };
  const bool small_enough =
      have_texels_within(scene.textures, limits.max_texels);  // first: sound() multiplies sides
  if (!small_enough || !all_sound(scene.textures)) return broken("textures");
  if (scene.materials.empty() || !all_sound(scene.materials, scene)) return broken("materials");
  if (!all_sound(scene.meshes, scene)) return broken("meshes");
  for (size_t i = 0; i < scene.moving_nodes.size(); ++i) {
    if (!sound(scene.moving_nodes[i], i)) return broken("animations");
  }
  if (scene.instances.size() > limits.max_instances || !all_sound(scene.instances, scene)) {
    return broken("instances");
  }
  if (scene.lights.size() > limits.max_lights || !all_sound(scene.lights, scene)) return broken("lights");
  if (scene.cameras.empty() || !all_sound(scene.cameras) || !all_sound(scene.paths, scene)) {
    return broken("cameras");
  }
  if (triangles(scene, limits.max_triangles) != scene.triangle_count) return broken("counts");
  const Geometry* made = scene.geometry.get();
  if (made && !(sound(made->mesh, scene) && sound(made->clusters, made->mesh))) return broken("triangles");
  if (!sound(scene.surroundings)) return broken("surroundings");
  if (scene.period.count() < 0 || !finite(scene.bounds.min) || !finite(scene.bounds.max)) return broken("bounds");
  return {};
}

}  // namespace gnomon::scenes
