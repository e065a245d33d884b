// The bvh tracer against a test of every triangle in C++, over the very same surface points: no bit may differ.
#include <gtest/gtest.h>

#include "gpu/builds/bvh.h"
#include "gpu/scene/resident_scene.h"
#include "scenes/world_mesh.h"
#include "tests/unit/gpu/brute_force.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWidth = 100, kHeight = 60;  // no multiples of the tile size

class BruteForce : public testing::TestWithParam<uint32_t> {};

TEST_P(BruteForce, EqualsBvhOnTriangleSoups) {
  const uint32_t seed = GetParam();
  const auto scene = triangle_soup(seed, 40 + 90 * seed, 4);
  auto probe = SurfaceProbe::create(device_options("bvh"), scene);
  ASSERT_TRUE(probe) << probe.error().message;
  const CameraView camera =
      look_at({0.5f + 0.2f * static_cast<float>(seed % 3), 0.6f, 2.2f}, {0.5f, 0.5f, 0.5f}, 0.8f, kWidth, kHeight);
  const auto frame = probe->render(camera, kWidth, kHeight);
  ASSERT_TRUE(frame) << frame.error().message;
  const Count count = compare(*scene, camera, *frame);
  EXPECT_EQ(count.differing, 0u) << "of " << count.surfaces * scene->lights.size();
  EXPECT_GT(count.surfaces, 500u);
  EXPECT_GT(count.lit, 200u);
  EXPECT_GT(count.dark, 200u);
}

INSTANTIATE_TEST_SUITE_P(Seeds, BruteForce, testing::Range(1u, 9u));

TEST(BruteForceTest, EqualsBvhWithTheCameraAmongTheTriangles) {
  const auto scene = triangle_soup(77, 500, 6);
  auto probe = SurfaceProbe::create(device_options("bvh"), scene);
  ASSERT_TRUE(probe) << probe.error().message;
  const CameraView camera = look_at({0.5f, 0.5f, 0.5f}, {0.1f, 0.3f, 0.9f}, 1.4f, kWidth, kHeight);
  const auto frame = probe->render(camera, kWidth, kHeight);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_EQ(compare(*scene, camera, *frame).differing, 0u);
}

// Large coordinates make roundings large: the boxes must be widened with them.
TEST(BruteForceTest, EqualsBvhFarFromTheOrigin) {
  const auto near = triangle_soup(5, 300, 4);
  auto far = std::make_shared<scenes::Scene>(*near);
  const glm::vec3 shift(3000.0f, -500.0f, 1700.0f);
  for (glm::vec3& p : far->meshes[0].primitives[0].positions) p += shift;
  for (scenes::Light& light : far->lights) light.position += shift;
  far->bounds = {near->bounds.min + shift, near->bounds.max + shift};
  auto probe = SurfaceProbe::create(device_options("bvh"), far);
  ASSERT_TRUE(probe) << probe.error().message;
  const CameraView camera = look_at(shift + glm::vec3(0.5f, 0.6f, 2.2f), shift + 0.5f, 0.8f, kWidth, kHeight);
  const auto frame = probe->render(camera, kWidth, kHeight);
  ASSERT_TRUE(frame) << frame.error().message;
  const Count count = compare(*far, camera, *frame);
  EXPECT_EQ(count.differing, 0u);
  EXPECT_GT(count.lit, 100u);
}

// More lights than a shader pass packs at a time, and than a 32-bit word holds.
TEST(BruteForceTest, SeventyLightsEachHaveTheirOwnPlane) {
  const auto scene = triangle_soup(3, 120, 70);
  for (const std::string& tracer : tracers()) {
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    const CameraView camera = look_at({0.5f, 0.6f, 2.2f}, {0.5f, 0.5f, 0.5f}, 0.8f, kWidth, kHeight);
    const auto frame = probe->render(camera, kWidth, kHeight);
    ASSERT_TRUE(frame) << frame.error().message;
    ASSERT_EQ(frame->grid.planes, 70u);
    const Count count = compare(*scene, camera, *frame);
    if (tracer == "bvh") {
      EXPECT_EQ(count.differing, 0u);
    }
    // The device's own triangle test may round differently; a misplaced plane would differ by far more.
    EXPECT_LE(count.differing, count.surfaces * 70 / 1000) << tracer;
  }
}

TEST(BvhBuild, DoesNotDependOnTheNumberOfThreads) {
  const scenes::WorldMesh mesh = scenes::build_world_mesh(*triangle_soup(9, 30000, 1));
  const Bvh one = build_bvh(mesh, 1), two = build_bvh(mesh, 2);
  ASSERT_EQ(one.nodes.size(), two.nodes.size());
  for (size_t i = 0; i < one.nodes.size(); ++i) {
    ASSERT_EQ(one.nodes[i].skip, two.nodes[i].skip);
    ASSERT_EQ(one.nodes[i].leaf, two.nodes[i].leaf);
  }
}

TEST(BvhBuild, EveryTriangleIsInOneLeafWithinItsBoxes) {
  const scenes::WorldMesh mesh = scenes::build_world_mesh(*triangle_soup(4, 5000, 1));
  const Bvh bvh = build_bvh(mesh, 2);
  std::vector<int> seen(mesh.triangles.size());
  std::vector<std::pair<uint32_t, BvhNode>> open;  // end of the subtree, its root
  for (uint32_t n = 0; n < bvh.nodes.size(); ++n) {
    const BvhNode& node = bvh.nodes[n];
    while (!open.empty() && open.back().first <= n) open.pop_back();
    if (node.leaf == 0) {
      open.emplace_back(node.skip, node);
      continue;
    }
    ASSERT_EQ(node.skip, n + 1);
    for (uint32_t i = 0; i < (node.leaf & 15u); ++i) {
      const BvhTriangle& t = bvh.triangles[(node.leaf >> 4) + i];
      ++seen[t.triangle];
      for (const glm::vec3& p : {t.p0, t.p1, t.p2})
        for (const auto& [end, box] : open)
          ASSERT_TRUE(glm::all(glm::lessThanEqual(box.lo, p)) && glm::all(glm::lessThanEqual(p, box.hi)));
    }
  }
  for (const int times : seen) ASSERT_EQ(times, 1);
}

TEST(BvhBuild, TrianglesOnOneSpotAreDivided) {
  scenes::WorldMesh mesh;
  mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  mesh.triangles.assign(1000, {0, 1, 2});
  mesh.materials.assign(1000, 0);
  mesh.opaque_count = 1000;
  const Bvh bvh = build_bvh(mesh, 2);
  uint32_t in_leaves = 0;
  for (const BvhNode& node : bvh.nodes) in_leaves += node.leaf & 15u;
  EXPECT_EQ(in_leaves, 1000u);
}

}  // namespace
}  // namespace gnomon::test
