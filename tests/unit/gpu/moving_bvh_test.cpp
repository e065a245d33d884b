// The hierarchy over moving geometry: whatever the pose, it holds all triangles where they are; it is built anew when the
// motion has made it loose, and not before.
#include "gpu/builds/moving_bvh.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <random>
#include <set>

namespace gnomon::test {
namespace {

using namespace gpu;

// `bodies` clouds of small triangles, each within the unit cube at its place.
scenes::WorldMesh clouds(const std::vector<glm::vec3>& places, float angle = 0.0f) {
  const glm::mat4 turn = glm::rotate(glm::mat4(1.0f), angle, glm::vec3(0, 1, 0));
  scenes::WorldMesh mesh;
  for (const glm::vec3& place : places) {
    std::mt19937 random(7);
    std::uniform_real_distribution<float> unit(0.0f, 1.0f);
    const auto point = [&] { return glm::vec3(unit(random), unit(random), unit(random)); };
    for (int i = 0; i < 200; ++i) {
      const glm::vec3 corner = point();
      const auto base = static_cast<uint32_t>(mesh.positions.size());
      for (const glm::vec3& p : {corner, corner + 0.1f * point(), corner + 0.1f * point()})
        mesh.positions.push_back(place + glm::vec3(turn * glm::vec4(p, 1.0f)));
      mesh.triangles.emplace_back(base, base + 1, base + 2);
    }
  }
  mesh.opaque_count = static_cast<uint32_t>(mesh.triangles.size()) - 10;
  return mesh;
}

void expect_holds_all(const Bvh& bvh, const scenes::WorldMesh& mesh) {
  std::set<uint32_t> held;
  for (const BvhTriangle& t : bvh.triangles) {
    ASSERT_LT(t.triangle, mesh.triangles.size());
    held.insert(t.triangle);
    const glm::uvec3 corners = mesh.triangles[t.triangle];
    EXPECT_EQ(t.p0, mesh.positions[corners.x]);
    EXPECT_EQ(t.p1, mesh.positions[corners.y]);
    EXPECT_EQ(t.p2, mesh.positions[corners.z]);
    EXPECT_EQ(t.masked != 0, t.triangle >= mesh.opaque_count);
  }
  EXPECT_EQ(held.size(), mesh.triangles.size());
  std::vector<int> leaves(bvh.triangles.size());
  for (uint32_t n = 0; n < bvh.nodes.size(); ++n) {
    for (uint32_t below = n; below < bvh.nodes[n].skip; ++below) {
      const uint32_t leaf = bvh.nodes[below].leaf;
      for (uint32_t i = leaf >> 4; i < (leaf >> 4) + (leaf & 15); ++i) {
        for (const glm::vec3& p : {bvh.triangles[i].p0, bvh.triangles[i].p1, bvh.triangles[i].p2}) {
          EXPECT_TRUE(glm::all(glm::lessThanEqual(bvh.nodes[n].lo, p)) &&
                      glm::all(glm::greaterThanEqual(bvh.nodes[n].hi, p)))
              << "triangle " << i << " in node " << n;
        }
        if (below == n) ++leaves[i];
      }
    }
  }
  for (const int count : leaves) EXPECT_EQ(count, 1);
}

void expect_cut(const std::vector<BvhPart>& parts, const Bvh& bvh) {
  std::set<uint32_t> nodes;
  for (const BvhPart& part : parts) {
    EXPECT_EQ(part.lo, bvh.nodes[part.first].lo);
    EXPECT_EQ(part.hi, bvh.nodes[part.first].hi);
    for (uint32_t n = part.first; n < part.end; ++n) EXPECT_TRUE(nodes.insert(n).second) << n;
  }
  for (uint32_t n = 0; n < bvh.nodes.size(); ++n)
    EXPECT_TRUE(bvh.nodes[n].leaf == 0 || nodes.contains(n)) << "leaf " << n;
}

TEST(MovingBvh, HoldsAllTrianglesInEveryPose) {
  MovingBvh moving;
  for (int step = 0; step < 8; ++step) {
    const auto t = static_cast<float>(step);
    const scenes::WorldMesh mesh = clouds({{0.1f * t, 0, 0}, {3, 0.2f * t, 0}, {0, 0, 3 - 0.3f * t}}, 0.2f * t);
    const Bvh& bvh = moving.follow(mesh);
    expect_holds_all(bvh, mesh);
    const std::vector<BvhPart> parts = parts_of(bvh);
    EXPECT_EQ(parts.size(), kMostParts);
    expect_cut(parts, bvh);
  }
}

// Boxes are tight around the axes that they were built for, and those above several bodies grow as these part.
TEST(MovingBvh, BodiesThatTurnAndTravelSeldomGetANewTree) {
  MovingBvh moving;
  for (int step = 0; step < 200; ++step) {
    const auto t = static_cast<float>(step);
    moving.follow(clouds({{0, 0, 0.02f * t}, {4 + 0.03f * t, 0, 0}}, 0.03f * t));
  }
  EXPECT_LE(moving.builds(), 10u);
}

TEST(MovingBvh, BodiesThatComeApartGetANewTree) {
  MovingBvh moving;
  moving.follow(clouds({{0, 0, 0}, {0.05f, 0, 0}}));  // one tree over both, mixed
  const scenes::WorldMesh apart = clouds({{0, 0, 0}, {8, 0, 0}});
  const Bvh& bvh = moving.follow(apart);
  EXPECT_EQ(moving.builds(), 2u);
  expect_holds_all(bvh, apart);
  moving.follow(clouds({{0, 0, 0}, {8.1f, 0, 0}}));
  EXPECT_EQ(moving.builds(), 2u) << "the new one is followed in its turn";
}

TEST(MovingBvh, AnotherNumberOfTrianglesGetsANewTree) {
  MovingBvh moving;
  moving.follow(clouds({{0, 0, 0}, {4, 0, 0}}));
  const scenes::WorldMesh fewer = clouds({{0, 0, 0}});
  expect_holds_all(moving.follow(fewer), fewer);
  EXPECT_EQ(moving.builds(), 2u);
  EXPECT_TRUE(moving.follow({}).nodes.empty());
  EXPECT_TRUE(parts_of(moving.follow({})).empty());
}

TEST(MovingBvh, FewTrianglesAreFewParts) {
  scenes::WorldMesh one;
  one.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  one.triangles = {{0, 1, 2}};
  one.opaque_count = 1;
  MovingBvh moving;
  const Bvh& bvh = moving.follow(one);
  const std::vector<BvhPart> parts = parts_of(bvh);
  ASSERT_EQ(parts.size(), 1u);
  expect_cut(parts, bvh);
}

}  // namespace
}  // namespace gnomon::test
