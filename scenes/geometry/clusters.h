// The world mesh in clusters: neighbouring triangles that are culled together, by their box and by the cone of their
// normals (Shirman and Abi-Ezzi, "The Cone of Normals Technique for Fast Processing of Curved Patches", 1993).
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/on_share.h"
#include "scenes/world_mesh.h"

namespace gnomon::scenes {

// As in shaders/cull.comp: invocations of a workgroup, bits of a word.
inline constexpr uint32_t kMaxTrianglesInCluster = 64;
inline constexpr uint32_t kMaxClustersInChunk = 32;

// A contiguous range of triangles and its bounds. shaders/cull.glsl declares the same struct.
struct Cluster {
  glm::vec3 box_min{0.0f};
  uint32_t first_triangle = 0;
  glm::vec3 box_max{0.0f};
  uint32_t triangle_count = 0;  // at most kMaxTrianglesInCluster
  // The faces' normals are within a cone; cutoff is the sine of its half angle. 1: too wide, or double-sided.
  glm::vec3 cone_axis{0.0f};
  float cone_cutoff = 1.0f;
};
static_assert(sizeof(Cluster) == 48);

// A contiguous range of clusters that one workgroup tests and one indirect command draws.
struct ClusterChunk {
  uint32_t first_cluster = 0;
  uint32_t cluster_count = 0;  // at most kMaxClustersInChunk
  uint32_t double_sided = 0;
  uint32_t masked = 0;
};

// A contiguous range of clusters that one pipeline state draws.
struct ClusterGroup {
  uint32_t first_triangle = 0, triangle_count = 0;
  uint32_t first_chunk = 0, chunk_count = 0;
  bool masked = false;        // has an alpha test
  bool double_sided = false;  // drawn from both sides
};

// A frame draws its groups, and hence its triangles, in their order: of two equally near triangles the first one shows,
// whatever has been culled. `occluders` are the few large opaque triangles, which hide many of the others.
struct Clusters {
  std::vector<uint32_t> numbers;  // for each triangle: its number in build_world_mesh
  std::vector<Cluster> clusters;
  std::vector<ClusterChunk> chunks;
  std::array<ClusterGroup, 2> occluders;
  std::array<ClusterGroup, 4> others;

  uint32_t chunk_count() const { return static_cast<uint32_t>(chunks.size()); }
};

// Reorders the triangles of `mesh` by cluster; opaque ones still come first. The order depends only on what
// Scene::content_hash covers, and on the version of meshoptimizer.
Clusters make_clusters(const Scene& scene, WorldMesh& mesh, const OnShare& on_share = {});

}  // namespace gnomon::scenes
