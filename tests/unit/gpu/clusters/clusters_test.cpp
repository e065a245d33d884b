// Clusters keep every triangle, and their bounds contain their triangles.
#include "scenes/geometry/clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

#include "tests/unit/gpu/made_scenes.h"

namespace gnomon::test {
namespace {

using scenes::Cluster;
using scenes::ClusterGroup;
using scenes::Clusters;
using scenes::WorldMesh;

// Materials: single-sided, double-sided, and the same two with an alpha test.
std::shared_ptr<scenes::Scene> mixed_scene(uint32_t triangles) {
  auto scene = std::make_shared<scenes::Scene>(*triangle_soup(3, triangles, 1));
  scene->textures.push_back({1, 1, scenes::Wrap::repeat, scenes::Wrap::repeat, true, {255, 255, 255, 0}});
  scene->materials.resize(4);
  const scenes::Primitive all = scene->meshes[0].primitives[0];
  scene->meshes[0].primitives.clear();
  for (uint32_t m = 0; m < 4; ++m) {
    scene->materials[m].double_sided = m % 2 == 1;
    if (m >= 2) {
      scene->materials[m].alpha_mode = scenes::AlphaMode::mask;
      scene->materials[m].base_color_texture = 0;
    }
    scenes::Primitive part = all;
    part.material = m;
    part.triangles.clear();
    std::mt19937 random(8);
    for (const glm::uvec3& t : all.triangles)
      if (random() % 4 == m) part.triangles.push_back(t);
    scene->meshes[0].primitives.push_back(std::move(part));
  }
  return scene;
}

struct Built {
  std::shared_ptr<scenes::Scene> scene;
  WorldMesh before, mesh;
  Clusters clusters;

  explicit Built(std::shared_ptr<scenes::Scene> s)
      : scene(std::move(s)),
        before(build_world_mesh(*scene)),
        mesh(before),
        clusters(scenes::make_clusters(*scene, mesh)) {}
};

TEST(Clusters, KeepEveryTriangle) {
  const Built built(mixed_scene(5000));
  ASSERT_EQ(built.mesh.triangles.size(), built.before.triangles.size());
  ASSERT_EQ(built.clusters.numbers.size(), built.before.triangles.size());
  std::vector<uint32_t> seen = built.clusters.numbers;
  for (size_t t = 0; t < seen.size(); ++t) {
    ASSERT_EQ(built.mesh.triangles[t], built.before.triangles[seen[t]]);
    ASSERT_EQ(built.mesh.materials[t], built.before.materials[seen[t]]);
  }
  std::sort(seen.begin(), seen.end());
  for (uint32_t t = 0; t < seen.size(); ++t) ASSERT_EQ(seen[t], t);
}

TEST(Clusters, EqualTrianglesAreKeptApart) {
  const std::vector<glm::vec3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const Built built(std::make_shared<scenes::Scene>(
      *make_scene(corners, std::vector<glm::uvec3>(300, {0, 1, 2}), {point_light({0, 0, 1})})));
  std::vector<uint32_t> seen = built.clusters.numbers;
  std::sort(seen.begin(), seen.end());
  for (uint32_t t = 0; t < 300; ++t) ASSERT_EQ(seen[t], t);
}

TEST(Clusters, GroupsFollowEachOtherAndAreWhatTheySay) {
  const Built built(mixed_scene(5000));
  std::vector<ClusterGroup> groups(built.clusters.occluders.begin(), built.clusters.occluders.end());
  groups.insert(groups.end(), built.clusters.others.begin(), built.clusters.others.end());
  uint32_t next_triangle = 0, next_chunk = 0, kinds = 0;
  for (const ClusterGroup& group : groups) {
    EXPECT_EQ(group.first_triangle, next_triangle);
    EXPECT_EQ(group.first_chunk, next_chunk);
    next_triangle += group.triangle_count;
    next_chunk += group.chunk_count;
    kinds += group.triangle_count > 0;
    for (uint32_t t = group.first_triangle; t < next_triangle; ++t) {
      const scenes::Material& material = built.scene->materials[built.mesh.materials[t]];
      ASSERT_EQ(material.double_sided, group.double_sided);
      ASSERT_EQ(material.alpha_mode == scenes::AlphaMode::mask, group.masked);
      ASSERT_EQ(t < built.mesh.opaque_count, !group.masked);
    }
  }
  EXPECT_EQ(kinds, 6u);
  EXPECT_EQ(next_triangle, built.mesh.triangles.size());
  EXPECT_EQ(next_chunk, built.clusters.chunk_count());
}

TEST(Clusters, ChunksHoldEveryClusterOnce) {
  const Built built(mixed_scene(20000));
  uint32_t next_cluster = 0, next_triangle = 0;
  for (const scenes::ClusterChunk& chunk : built.clusters.chunks) {
    EXPECT_EQ(chunk.first_cluster, next_cluster);
    EXPECT_GE(chunk.cluster_count, 1u);
    EXPECT_LE(chunk.cluster_count, 32u);
    next_cluster += chunk.cluster_count;
  }
  ASSERT_EQ(next_cluster, built.clusters.clusters.size());
  for (const Cluster& cluster : built.clusters.clusters) {
    EXPECT_EQ(cluster.first_triangle, next_triangle);
    EXPECT_LE(cluster.triangle_count, 64u);
    next_triangle += cluster.triangle_count;
  }
}

TEST(Clusters, BoundsContainTheirTriangles) {
  const Built built(mixed_scene(5000));
  for (const Cluster& cluster : built.clusters.clusters)
    for (uint32_t t = cluster.first_triangle; t < cluster.first_triangle + cluster.triangle_count; ++t)
      for (int corner = 0; corner < 3; ++corner) {
        const glm::vec3 p = built.mesh.positions[built.mesh.triangles[t][corner]];
        ASSERT_TRUE(glm::all(glm::lessThanEqual(cluster.box_min, p)));
        ASSERT_TRUE(glm::all(glm::greaterThanEqual(cluster.box_max, p)));
      }
}

// A bumpy sphere: its faces look every way, those of a cluster nearly one.
std::shared_ptr<scenes::Scene> sphere(uint32_t rings) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  const uint32_t around = 2 * rings;
  for (uint32_t i = 0; i <= rings; ++i)
    for (uint32_t j = 0; j < around; ++j) {
      const float a = 3.14159265f * static_cast<float>(i) / static_cast<float>(rings);
      const float b = 6.2831853f * static_cast<float>(j) / static_cast<float>(around);
      const float radius = 1.0f + 0.02f * std::sin(9.0f * a) * std::cos(7.0f * b);
      positions.emplace_back(radius * std::sin(a) * std::cos(b), radius * std::cos(a),
                             radius * -std::sin(a) * std::sin(b));
    }
  for (uint32_t i = 0; i < rings; ++i)
    for (uint32_t j = 0; j < around; ++j) {
      const uint32_t p = i * around + j, q = i * around + (j + 1) % around;
      triangles.push_back({p, p + around, q + around});
      triangles.push_back({p, q + around, q});
    }
  return std::make_shared<scenes::Scene>(*make_scene(positions, triangles, {point_light({0, 3, 0})}));
}

// What shaders/cull.comp takes for granted: where the cone's test says so, every face turns its back.
TEST(Clusters, ConesKnowWhenAllFacesTurnTheirBack) {
  const Built built(sphere(64));
  std::mt19937 random(4);
  std::uniform_real_distribution<float> any(-4.0f, 4.0f);
  uint64_t culled = 0, backs = 0;
  for (int view = 0; view < 50; ++view) {
    const glm::vec3 eye(any(random), any(random), any(random));
    for (const Cluster& cluster : built.clusters.clusters) {
      const glm::vec3 middle = 0.5f * (cluster.box_min + cluster.box_max) - eye;
      const float radius = 0.5f * glm::length(cluster.box_max - cluster.box_min);
      const bool away = glm::dot(middle, cluster.cone_axis) > cluster.cone_cutoff * glm::length(middle) + radius;
      bool all_backs = true;
      for (uint32_t t = cluster.first_triangle; t < cluster.first_triangle + cluster.triangle_count; ++t) {
        const glm::uvec3 c = built.mesh.triangles[t];
        const glm::vec3 p = built.mesh.positions[c.x];
        const glm::vec3 n = glm::cross(built.mesh.positions[c.y] - p, built.mesh.positions[c.z] - p);
        all_backs &= glm::dot(n, p - eye) >= 0.0f;
      }
      ASSERT_TRUE(all_backs || !away);
      culled += away;
      backs += all_backs;
    }
  }
  EXPECT_GT(culled, backs / 2) << "the cones are too wide to be of use";
}

TEST(Clusters, DoNotDependOnHowVerticesAreShared) {
  const Built shared(sphere(20));
  auto apart = std::make_shared<scenes::Scene>(*shared.scene);
  scenes::Primitive& primitive = apart->meshes[0].primitives[0];
  std::vector<glm::vec3> positions;
  for (glm::uvec3& t : primitive.triangles) {
    for (int corner = 0; corner < 3; ++corner) positions.push_back(primitive.positions[t[corner]]);
    const auto next = static_cast<uint32_t>(positions.size());
    t = {next - 3, next - 2, next - 1};
  }
  primitive.positions = positions;
  EXPECT_EQ(Built(apart).clusters.numbers, shared.clusters.numbers);
}

TEST(Clusters, ASceneWithoutTrianglesHasNone) {
  const Built built(std::make_shared<scenes::Scene>(*make_scene({}, {}, {})));
  EXPECT_TRUE(built.clusters.clusters.empty());
  EXPECT_EQ(built.clusters.chunk_count(), 0u);
}

}  // namespace
}  // namespace gnomon::test
