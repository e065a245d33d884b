// Culling changes no pixel: the triangle that each shows is the one of drawing everything, bit for bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <random>

#include "gpu/passes/passes.h"
#include "gpu/picture/blocking_frame.h"
#include "scenes/loader.h"
#include "tests/unit/gpu/cameras.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using gpu::BlockingFrame;
using gpu::CameraView;
namespace fs = std::filesystem;
namespace resource = gpu::resource;

// One scene through the same cameras, culled and not.
class Compared {
 public:
  explicit Compared(const scenes::ScenePtr& scene)
      : all_(make(scene, {"gbuffer_all", "surface", "readback_surface"})),
        culled_(make(scene, {"gbuffer", "surface", "readback_surface", "readback_draws"})) {}

  struct Outcome {
    uint64_t differing = 0, surfaces = 0, drawn = 0, triangles = 0;
  };
  Outcome look(const CameraView& camera, uint32_t width, uint32_t height) {
    const auto all = triangles(*all_, camera, width, height), culled = triangles(*culled_, camera, width, height);
    Outcome out;
    for (size_t i = 0; i < all.size(); ++i) {
      out.differing += all[i] != culled[i];
      out.surfaces += all[i] != 0;
    }
    const scenes::Clusters& clusters = culled_->scene().clusters();
    const uint32_t first_other = clusters.others[0].first_chunk;
    out.drawn = drawn(resource::kHostOccluderDraws, 0, first_other) +
                drawn(resource::kHostDraws, first_other, clusters.chunk_count());
    out.triangles = culled_->scene().triangle_count();
    return out;
  }

 private:
  static std::unique_ptr<BlockingFrame> make(const scenes::ScenePtr& scene, std::vector<std::string> passes) {
    auto frame = BlockingFrame::create(device_options(), passes, scene);
    EXPECT_TRUE(frame) << frame.error().message;
    return std::move(*frame);
  }

  static std::vector<uint32_t> triangles(BlockingFrame& frame, const CameraView& camera, uint32_t width,
                                         uint32_t height) {
    const auto grid = frame.reserve(width, height);
    EXPECT_TRUE(grid);
    EXPECT_TRUE(frame.render(camera, *grid));
    const auto* samples = reinterpret_cast<const gpu::SurfaceSample*>(frame.host(resource::kHostSurface).data());
    std::vector<uint32_t> out(size_t{width} * height);
    for (size_t i = 0; i < out.size(); ++i) out[i] = samples[i].triangle;
    return out;
  }

  uint64_t drawn(std::string_view name, uint32_t first_chunk, uint32_t end_chunk) const {
    const auto* draws = reinterpret_cast<const VkDrawIndirectCommand*>(culled_->host(name).data());
    uint64_t count = 0;
    for (uint32_t chunk = first_chunk; chunk < end_chunk; ++chunk) count += draws[chunk].vertexCount / 3;
    return count;
  }

  std::unique_ptr<BlockingFrame> all_, culled_;
};

void compare(const scenes::ScenePtr& scene, int views) {
  Compared compared(scene);
  Cameras cameras(*scene, 11);
  Compared::Outcome sum;
  for (int i = 0; i < views; ++i) {
    const uint32_t width = i % 2 ? 333 : 200, height = i % 3 ? 187 : 121;
    const Compared::Outcome outcome = compared.look(cameras.next(), width, height);
    EXPECT_EQ(outcome.differing, 0u) << scene->name << ", view " << i;
    sum.surfaces += outcome.surfaces;
    sum.drawn += outcome.drawn;
    sum.triangles += outcome.triangles;
  }
  EXPECT_GT(sum.surfaces, 1000u * static_cast<unsigned>(views)) << scene->name;
  EXPECT_LT(sum.drawn, sum.triangles / 2) << scene->name;
}

scenes::ScenePtr load(const fs::path& file) {
  auto scene = scenes::load_scene(file);
  EXPECT_TRUE(scene) << scene.error().message;
  return *scene;
}

TEST(Culling, ChangesNoPixelOfTheBuiltInScenes) {
  for (const char* name : {"living_room.glb", "temple.glb"}) compare(load(fs::path(GNOMON_SCENES_DIR) / name), 40);
}

TEST(Culling, ChangesNoPixelOfScenesFromOthers) {
  for (const char* name : {"sponza_crytek.glb", "oa_minia.glb", "country_kitchen.glb"}) {
    const fs::path file = fs::path(GNOMON_SOURCE_DIR) / "../shared/scenes" / name;
    if (fs::exists(file))
      compare(load(file), 25);
    else
      std::printf("not there, skipped: %s\n", name);
  }
}

// Slivers and triangles that span all of the view, from one side and from both.
TEST(Culling, ChangesNoPixelOfSoups) {
  for (const uint32_t triangles : {1u, 64u, 65u, 3000u})
    for (const bool double_sided : {false, true}) {
      auto scene = std::make_shared<scenes::Scene>(*triangle_soup(triangles, triangles, 1));
      scene->materials[0].double_sided = double_sided;
      Compared compared(scene);
      Cameras cameras(*scene, triangles);
      for (int i = 0; i < 20; ++i)
        EXPECT_EQ(compared.look(cameras.next(), 320, 180).differing, 0u) << triangles << " triangles, view " << i;
    }
}

// A floor of `cells` x `cells` squares at height 0, over |x|, |z| < half.
void add_floor(std::vector<glm::vec3>& positions, std::vector<glm::uvec3>& triangles, uint32_t cells, float half) {
  const auto base = static_cast<uint32_t>(positions.size());
  for (uint32_t z = 0; z <= cells; ++z)
    for (uint32_t x = 0; x <= cells; ++x)
      positions.emplace_back(half * (2.0f * static_cast<float>(x) / static_cast<float>(cells) - 1.0f), 0.0f,
                             half * (2.0f * static_cast<float>(z) / static_cast<float>(cells) - 1.0f));
  for (uint32_t z = 0; z < cells; ++z)
    for (uint32_t x = 0; x < cells; ++x) {
      const uint32_t p = base + z * (cells + 1) + x, q = p + cells + 1;
      triangles.push_back({p, q, q + 1});
      triangles.push_back({p, q + 1, p + 1});
    }
}

// Where several triangles are equally near the first one shows, whether others have been culled or not.
TEST(Culling, KeepsTheChoiceAmongEquallyNearTriangles) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  for (const uint32_t cells : {8u, 2u, 40u, 16u, 2u}) add_floor(positions, triangles, cells, 4.0f);
  Compared compared(make_scene(positions, triangles, {point_light({0, 3, 0})}));
  std::mt19937 random(6);
  std::uniform_real_distribution<float> any(-4.0f, 4.0f), above(0.2f, 3.0f);
  for (int i = 0; i < 40; ++i) {
    const glm::vec3 eye(any(random), above(random), any(random)), at(any(random), 0.0f, any(random));
    const auto outcome = compared.look(look_at(eye, at, 0.8f, 320, 180), 320, 180);
    EXPECT_EQ(outcome.differing, 0u) << "view " << i;
    EXPECT_GT(outcome.surfaces, 1000u) << "view " << i;
  }
}

TEST(Culling, DrawsNothingWhenLookingAway) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  add_floor(positions, triangles, 60, 4.0f);
  Compared compared(make_scene(positions, triangles, {point_light({0, 3, 0})}));
  const glm::vec3 eye(0, 1, 8);
  const auto towards = compared.look(look_at(eye, {0, 0, 0}, 0.9f, 320, 180), 320, 180);
  const auto away = compared.look(look_at(eye, {0, 2, 16}, 0.9f, 320, 180), 320, 180);
  EXPECT_GT(towards.drawn, 1000u);
  EXPECT_EQ(away.drawn, 0u);
}

TEST(Culling, FollowsTheSidesOfMaterials) {
  auto scene = std::make_shared<scenes::Scene>(*square_over_floor(point_light({0, 3, 0})));
  const CameraView above = look_at({1, 3, 1}, {0, 0, 0}, 0.6f, 160, 90);
  const CameraView below = look_at({1, -3, 1}, {0, 0, 0}, 0.6f, 160, 90);
  for (const bool double_sided : {false, true}) {
    for (scenes::Material& material : scene->materials) material.double_sided = double_sided;
    Compared compared(scene);
    EXPECT_EQ(compared.look(above, 160, 90).surfaces, 160u * 90u);
    EXPECT_EQ(compared.look(below, 160, 90).surfaces, double_sided ? 160u * 90u : 0u);
  }
}

// A wall, and behind it a floor of small triangles.
TEST(Culling, LeavesOutWhatTheLargeHide) {
  std::vector<glm::vec3> positions{{-9, -9, 5}, {9, -9, 5}, {9, 9, 5}, {-9, 9, 5}};
  std::vector<glm::uvec3> triangles{{0, 1, 2}, {0, 2, 3}};
  add_floor(positions, triangles, 60, 4.0f);
  Compared compared(make_scene(positions, triangles, {point_light({0, 3, 0})}));
  const auto outcome = compared.look(look_at({0, 1, 8}, {0, 0, 0}, 0.9f, 320, 180), 320, 180);
  EXPECT_EQ(outcome.differing, 0u);
  EXPECT_LT(outcome.drawn, outcome.triangles / 5);
}

}  // namespace
}  // namespace gnomon::test
