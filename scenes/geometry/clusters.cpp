#include "scenes/geometry/clusters.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <bit>
#include <limits>
#include <mutex>
#include <numeric>
#include <span>
#include <thread>
#include <utility>

#include "common/parallel.h"

namespace gnomon::scenes {
namespace {

constexpr size_t kMaxTriangles = kMaxTrianglesInCluster;
constexpr size_t kMaxVertices = 3 * kMaxTriangles;
constexpr float kConeWeight = 0.25f;  // the value that meshoptimizer recommends if cones are used
// The share of the opaque triangles, the largest, that are occluders: they are drawn without an occlusion test.
constexpr double kOccluderShare = 0.1;
constexpr size_t kMostInPiece = 32768;  // triangles that one call of meshoptimizer divides into clusters

// The mesh with corners at the same place merged into one vertex. It depends on positions only, so that the way a file
// shares its vertices does not change the clusters.
struct WeldedMesh {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
};

WeldedMesh weld(const WorldMesh& mesh) {
  WeldedMesh welded;
  if (mesh.triangles.empty()) return welded;
  const auto* indices = &mesh.triangles.front().x;
  const size_t index_count = 3 * mesh.triangles.size();
  std::vector<uint32_t> remap(mesh.positions.size());
  const size_t count = meshopt_generateVertexRemap(remap.data(), indices, index_count, mesh.positions.data(),
                                                   mesh.positions.size(), sizeof(glm::vec3));
  welded.positions.resize(count);
  welded.triangles.resize(mesh.triangles.size());
  meshopt_remapVertexBuffer(welded.positions.data(), mesh.positions.data(), mesh.positions.size(),
                            sizeof(glm::vec3), remap.data());
  meshopt_remapIndexBuffer(&welded.triangles.front().x, indices, index_count, remap.data());
  return welded;
}

float squared_area(const WeldedMesh& mesh, uint32_t triangle) {
  const glm::uvec3 t = mesh.triangles[triangle];
  const glm::vec3 p = mesh.positions[t.x];
  const glm::vec3 n = glm::cross(mesh.positions[t.y] - p, mesh.positions[t.z] - p);
  return glm::dot(n, n);
}

// The given triangles with vertices of their own, so that work on them does not grow with the rest of the mesh.
WeldedMesh part_of(const WeldedMesh& mesh, std::span<const uint32_t> members) {
  WeldedMesh part;
  part.triangles.reserve(members.size());
  // Open addressing, half full at most: a slot holds one more than the vertex's number in the part; 0: free.
  const size_t mask = std::bit_ceil(6 * members.size()) - 1;
  std::vector<std::pair<uint32_t, uint32_t>> slots(mask + 1);
  const auto number_of = [&](uint32_t vertex) {
    size_t at = (vertex * size_t{0x9e3779b1}) & mask;
    while (slots[at].second != 0 && slots[at].first != vertex) at = (at + 1) & mask;
    if (slots[at].second == 0) {
      part.positions.push_back(mesh.positions[vertex]);
      slots[at] = {vertex, static_cast<uint32_t>(part.positions.size())};
    }
    return slots[at].second - 1;
  };
  for (const uint32_t t : members) {
    const glm::uvec3 corners = mesh.triangles[t];
    const uint32_t x = number_of(corners.x), y = number_of(corners.y), z = number_of(corners.z);
    part.triangles.push_back({x, y, z});
  }
  return part;
}

// Finds the triangle that has a meshlet's corners; equal triangles are returned in the order of their numbers.
class Corners {
 public:
  explicit Corners(const WeldedMesh& mesh)
      : mesh_(mesh), first_(mesh.positions.size() + 1), by_first_(mesh.triangles.size()) {
    for (const glm::uvec3& t : mesh.triangles) ++first_[t.x + 1];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    std::vector<uint32_t> next(first_.begin(), first_.end() - 1);
    for (uint32_t t = 0; t < by_first_.size(); ++t) by_first_[next[mesh.triangles[t].x]++] = t;
  }

  uint32_t take(const glm::uvec3& corners) {
    const auto begin = by_first_.begin() + first_[corners.x], end = by_first_.begin() + first_[corners.x + 1];
    const auto found =
        std::find_if(begin, end, [&](uint32_t t) { return t != kTaken && mesh_.triangles[t] == corners; });
    return std::exchange(*found, kTaken);
  }

 private:
  static constexpr uint32_t kTaken = 0xffffffff;
  const WeldedMesh& mesh_;
  std::vector<uint32_t> first_, by_first_;
};

class Builder {
 public:
  Builder(const Scene& scene, WorldMesh& mesh, const OnShare& on_share)
      : scene_(scene), mesh_(mesh), on_share_(on_share), welded_(weld(mesh)) {}

  Clusters build() {
    const std::vector<bool> large = occluders();
    const uint32_t opaque = mesh_.opaque_count, all = static_cast<uint32_t>(mesh_.triangles.size());
    for (const bool double_sided : {false, true})
      add_group(out_.occluders[double_sided], 0, opaque, double_sided, [&](uint32_t t) { return large[t]; });
    for (const bool double_sided : {false, true})
      add_group(out_.others[double_sided], 0, opaque, double_sided, [&](uint32_t t) { return !large[t]; });
    for (const bool double_sided : {false, true})
      add_group(out_.others[2 + double_sided], opaque, all, double_sided, [](uint32_t) { return true; });
    reorder();
    return std::move(out_);
  }

 private:
  std::vector<bool> occluders() const {
    std::vector<bool> large(mesh_.opaque_count);
    std::vector<uint32_t> by_area(mesh_.opaque_count);
    std::iota(by_area.begin(), by_area.end(), 0u);
    const auto count = static_cast<ptrdiff_t>(kOccluderShare * mesh_.opaque_count);
    std::vector<float> areas(mesh_.opaque_count);
    for (const uint32_t t : by_area) areas[t] = squared_area(welded_, t);
    std::nth_element(by_area.begin(), by_area.begin() + count, by_area.end(),
                     [&](uint32_t a, uint32_t b) { return areas[a] != areas[b] ? areas[a] > areas[b] : a < b; });
    for (ptrdiff_t i = 0; i < count; ++i) large[by_area[static_cast<size_t>(i)]] = true;
    return large;
  }

  template <class Belongs>
  void add_group(ClusterGroup& group, uint32_t first, uint32_t end, bool double_sided, Belongs belongs) {
    std::vector<uint32_t> members;
    for (uint32_t t = first; t < end; ++t)
      if (scene_.materials[mesh_.materials[t]].double_sided == double_sided && belongs(t)) members.push_back(t);
    group.first_triangle = static_cast<uint32_t>(out_.numbers.size());
    group.triangle_count = static_cast<uint32_t>(members.size());
    group.masked = first >= mesh_.opaque_count && first != end;
    group.double_sided = double_sided;
    const uint32_t first_cluster = static_cast<uint32_t>(out_.clusters.size());
    if (!members.empty()) add_clusters(members, double_sided);
    add_chunks(group, first_cluster);
  }

  // Some clusters, and the numbers of their triangles. Cluster::first_triangle is an index into `numbers`.
  struct Piece {
    std::vector<uint32_t> numbers;
    std::vector<Cluster> clusters;
  };

  void add_clusters(std::vector<uint32_t>& members, bool double_sided) {
    std::vector<std::span<uint32_t>> parts;
    divide(members, parts);
    std::vector<Piece> pieces(parts.size());
    parallel_for(parts.size(), std::max(1u, std::thread::hardware_concurrency()), [&](size_t i) {
      pieces[i] = make_piece(parts[i], double_sided);
      count(parts[i].size());
    });
    for (const Piece& piece : pieces) {
      const auto first = static_cast<uint32_t>(out_.numbers.size());
      out_.numbers.insert(out_.numbers.end(), piece.numbers.begin(), piece.numbers.end());
      for (const Cluster& cluster : piece.clusters) {
        out_.clusters.push_back(cluster);
        out_.clusters.back().first_triangle += first;
      }
    }
  }

  // Any thread.
  void count(size_t triangles) {
    if (!on_share_) return;
    std::lock_guard lock(telling_);
    counted_ += triangles;
    on_share_(static_cast<double>(counted_) / static_cast<double>(mesh_.triangles.size()));
  }

  // Halves the triangles along the longest side until the parts are small enough to be shared among the cores. The
  // result does not depend on their number.
  void divide(std::span<uint32_t> members, std::vector<std::span<uint32_t>>& parts) const {
    if (members.size() <= kMostInPiece) return parts.push_back(members);
    glm::vec3 low(std::numeric_limits<float>::max()), high(-low);
    for (const uint32_t t : members) {
      const glm::vec3 p = welded_.positions[welded_.triangles[t].x];
      low = glm::min(low, p);
      high = glm::max(high, p);
    }
    const glm::vec3 sides = high - low;
    const int axis = sides.x >= sides.y && sides.x >= sides.z ? 0 : sides.y >= sides.z ? 1 : 2;
    const auto at = [&](uint32_t t) { return welded_.positions[welded_.triangles[t].x][axis]; };
    const size_t half = members.size() / 2;
    std::nth_element(members.begin(), members.begin() + static_cast<ptrdiff_t>(half), members.end(),
                     [&](uint32_t a, uint32_t b) { return at(a) != at(b) ? at(a) < at(b) : a < b; });
    for (const auto part : {members.first(half), members.subspan(half)}) {
      std::sort(part.begin(), part.end());
      divide(part, parts);
    }
  }

  Piece make_piece(std::span<const uint32_t> members, bool double_sided) const {
    const WeldedMesh part = part_of(welded_, members);
    const size_t index_count = 3 * members.size();
    const size_t most = meshopt_buildMeshletsBound(index_count, kMaxVertices, kMaxTriangles);
    std::vector<meshopt_Meshlet> meshlets(most);
    std::vector<uint32_t> vertices(most * kMaxVertices);
    std::vector<uint8_t> corners(most * kMaxTriangles * 3);
    meshlets.resize(meshopt_buildMeshlets(meshlets.data(), vertices.data(), corners.data(),
                                          &part.triangles.front().x, index_count, &part.positions.front().x,
                                          part.positions.size(), sizeof(glm::vec3), kMaxVertices, kMaxTriangles,
                                          double_sided ? 0.0f : kConeWeight));
    Corners known(part);
    Piece piece;
    for (const meshopt_Meshlet& meshlet : meshlets) {
      const uint32_t* v = &vertices[meshlet.vertex_offset];
      const uint8_t* c = &corners[meshlet.triangle_offset];
      const auto first = static_cast<uint32_t>(piece.numbers.size());
      for (uint32_t i = 0; i < meshlet.triangle_count; ++i, c += 3)
        piece.numbers.push_back(members[known.take({v[c[0]], v[c[1]], v[c[2]]})]);
      piece.clusters.push_back(bounds(piece.numbers, first, double_sided));
    }
    return piece;
  }

  // The cluster of the triangles from `first` on.
  Cluster bounds(const std::vector<uint32_t>& numbers, uint32_t first, bool double_sided) const {
    Cluster cluster;
    cluster.first_triangle = first;
    cluster.triangle_count = static_cast<uint32_t>(numbers.size()) - first;
    cluster.box_min = glm::vec3(std::numeric_limits<float>::max());
    cluster.box_max = -cluster.box_min;
    std::vector<glm::uvec3> triangles;
    for (size_t i = first; i < numbers.size(); ++i) {
      triangles.push_back(welded_.triangles[numbers[i]]);
      for (int corner = 0; corner < 3; ++corner) {
        const glm::vec3 p = welded_.positions[triangles.back()[corner]];
        cluster.box_min = glm::min(cluster.box_min, p);
        cluster.box_max = glm::max(cluster.box_max, p);
      }
    }
    if (double_sided) return cluster;
    const meshopt_Bounds cone =
        meshopt_computeClusterBounds(&triangles.front().x, 3 * triangles.size(), &welded_.positions.front().x,
                                     welded_.positions.size(), sizeof(glm::vec3));
    cluster.cone_axis = {cone.cone_axis[0], cone.cone_axis[1], cone.cone_axis[2]};
    cluster.cone_cutoff = cone.cone_cutoff;
    return cluster;
  }

  void add_chunks(ClusterGroup& group, uint32_t first_cluster) {
    group.first_chunk = out_.chunk_count();
    const auto end = static_cast<uint32_t>(out_.clusters.size());
    for (uint32_t c = first_cluster; c < end; c += kMaxClustersInChunk)
      out_.chunks.push_back({c, std::min(end - c, kMaxClustersInChunk), group.double_sided, group.masked});
    group.chunk_count = out_.chunk_count() - group.first_chunk;
  }

  void reorder() {
    std::vector<glm::uvec3> triangles;
    std::vector<uint32_t> materials;
    triangles.reserve(out_.numbers.size());
    materials.reserve(out_.numbers.size());
    for (const uint32_t t : out_.numbers) {
      triangles.push_back(mesh_.triangles[t]);
      materials.push_back(mesh_.materials[t]);
    }
    mesh_.triangles = std::move(triangles);
    mesh_.materials = std::move(materials);
  }

  const Scene& scene_;
  WorldMesh& mesh_;
  const OnShare& on_share_;
  std::mutex telling_;
  size_t counted_ = 0;  // triangles that are in clusters; guarded by telling_
  WeldedMesh welded_;
  Clusters out_;
};

}  // namespace

Clusters make_clusters(const Scene& scene, WorldMesh& mesh, const OnShare& on_share) {
  return Builder(scene, mesh, on_share).build();
}

}  // namespace gnomon::scenes
