// Rasterising in compute against the graphics pipeline: the same triangles in the same pixels, but where an edge passes
// a pixel's middle or two triangles are equally near, and nowhere a hole.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "gpu/passes/passes.h"
#include "gpu/picture/blocking_frame.h"
#include "scenes/loader.h"
#include "tests/unit/gpu/cameras.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;
namespace fs = std::filesystem;

struct Picture {
  uint32_t width = 0, height = 0;
  std::vector<SurfaceSample> at;

  const SurfaceSample& sample(uint32_t x, uint32_t y) const { return at[size_t{y} * width + x]; }
  bool shows_around(uint32_t triangle, uint32_t x, uint32_t y) const {
    for (uint32_t v = y > 0 ? y - 1 : 0; v <= std::min(y + 1, height - 1); ++v)
      for (uint32_t u = x > 0 ? x - 1 : 0; u <= std::min(x + 1, width - 1); ++u)
        if (sample(u, v).triangle == triangle) return true;
    return false;
  }
};

class Drawn {
 public:
  Drawn(const scenes::ScenePtr& scene, const std::string& pass) {
    auto frame = BlockingFrame::create(device_options(), {pass, "surface", "readback_surface"}, scene);
    EXPECT_TRUE(frame) << frame.error().message;
    frame_ = std::move(*frame);
  }
  Picture look(const CameraView& camera, uint32_t width, uint32_t height) {
    const auto grid = frame_->reserve(width, height);
    EXPECT_TRUE(grid);
    EXPECT_TRUE(frame_->render(camera, *grid));
    const auto* samples = reinterpret_cast<const SurfaceSample*>(frame_->host(resource::kHostSurface).data());
    return {width, height, {samples, samples + size_t{width} * height}};
  }

 private:
  std::unique_ptr<BlockingFrame> frame_;
};

struct Difference {
  uint64_t pixels = 0, surfaces = 0, edges = 0, ties = 0, unexplained = 0;
};

// Whether two triangles count as equally near: depths, which are written as floats, may differ in their last bits.
bool equally_near(const CameraView& camera, const SurfaceSample& a, const SurfaceSample& b) {
  const float da = glm::length(a.position - camera.position), db = glm::length(b.position - camera.position);
  return std::abs(da - db) <= 1e-3f * std::max(da, db);
}

// A pixel may differ if an edge passes through it: next to it, the other picture has this one's triangle, or nothing.
Difference compare(const Picture& hardware, const Picture& compute, const CameraView& camera) {
  Difference d;
  for (uint32_t y = 0; y < hardware.height; ++y)
    for (uint32_t x = 0; x < hardware.width; ++x) {
      const SurfaceSample &a = hardware.sample(x, y), &b = compute.sample(x, y);
      ++d.pixels;
      d.surfaces += a.triangle != 0;
      if (a.triangle == b.triangle) continue;
      const bool edge = hardware.shows_around(b.triangle, x, y) || compute.shows_around(a.triangle, x, y);
      const bool tie = a.triangle != 0 && b.triangle != 0 && equally_near(camera, a, b);
      d.ties += tie;
      d.edges += edge && !tie;
      d.unexplained += !edge && !tie;
    }
  return d;
}

Difference compare(const scenes::ScenePtr& scene, int views, uint32_t seed) {
  Drawn hardware(scene, "gbuffer_all"), compute(scene, "gbuffer_compute");
  Cameras cameras(*scene, seed);
  Difference sum;
  for (int i = 0; i < views; ++i) {
    const uint32_t width = i % 2 ? 333 : 200, height = i % 3 ? 187 : 121;
    const CameraView camera = cameras.next();
    const Difference d = compare(hardware.look(camera, width, height), compute.look(camera, width, height), camera);
    sum.pixels += d.pixels;
    sum.surfaces += d.surfaces;
    sum.edges += d.edges;
    sum.ties += d.ties;
    sum.unexplained += d.unexplained;
    EXPECT_LE(d.unexplained, d.pixels / 2000) << scene->name << ", view " << i;
  }
  std::printf("%s: of %llu pixels differ %llu at edges, %llu in ties, %llu otherwise\n", scene->name.c_str(),
              static_cast<unsigned long long>(sum.pixels), static_cast<unsigned long long>(sum.edges),
              static_cast<unsigned long long>(sum.ties), static_cast<unsigned long long>(sum.unexplained));
  EXPECT_GT(sum.surfaces, 1000u * static_cast<unsigned>(views));
  return sum;
}

class Raster : public testing::Test {
 protected:
  void SetUp() override {
    const auto device = Device::create({device_options().device, {}});
    ASSERT_TRUE(device);
    if (!(*device)->features().atomic_int64) GTEST_SKIP() << "skipped: the device has no 64-bit atomics";
  }
};

TEST_F(Raster, DrawsBuiltInScenesAsTheGraphicsPipeline) {
  for (const char* name : {"living_room.glb", "temple.glb"}) {
    const auto scene = scenes::load_scene(fs::path(GNOMON_SCENES_DIR) / name);
    ASSERT_TRUE(scene) << scene.error().message;
    const Difference d = compare(*scene, 30, 4);
    EXPECT_LE(d.edges, d.pixels / 1000) << name;
    EXPECT_LE(d.unexplained, d.pixels / 10'000) << name;
  }
}

TEST_F(Raster, DrawsScenesOfOthersAsTheGraphicsPipeline) {
  for (const char* name : {"sponza_crytek.glb", "oa_minia.glb"}) {
    const fs::path file = fs::path(GNOMON_SOURCE_DIR) / "../shared/scenes" / name;
    if (!fs::exists(file)) {
      std::printf("not there, skipped: %s\n", name);
      continue;
    }
    const auto scene = scenes::load_scene(file);
    ASSERT_TRUE(scene) << scene.error().message;
    const Difference d = compare(*scene, 20, 5);
    EXPECT_LE(d.edges, d.pixels / 1000) << name;
    EXPECT_LE(d.unexplained, d.pixels / 10'000) << name;
  }
}

// Slivers, triangles that span all of the view and such that the near plane cuts, from one side and from both.
TEST_F(Raster, DrawsSoupsAsTheGraphicsPipeline) {
  for (const uint32_t triangles : {1u, 65u, 3000u})
    for (const bool double_sided : {false, true}) {
      auto scene = std::make_shared<scenes::Scene>(*triangle_soup(triangles, triangles, 1));
      scene->materials[0].double_sided = double_sided;
      Drawn hardware(scene, "gbuffer_all"), compute(scene, "gbuffer_compute");
      Cameras cameras(*scene, triangles);
      for (int i = 0; i < 15; ++i) {
        const CameraView camera = cameras.next();
        const Difference d = compare(hardware.look(camera, 320, 180), compute.look(camera, 320, 180), camera);
        EXPECT_LE(d.unexplained, d.pixels / 1000) << triangles << " triangles, view " << i;
        EXPECT_LE(d.edges, d.pixels / 100) << triangles << " triangles, view " << i;
      }
    }
}

// `cells` x `cells` squares at height 0, over |x|, |z| < half, in two triangles each.
scenes::ScenePtr floor_of(uint32_t cells, float half) {
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  const auto place = [&](uint32_t i) {
    return half * (2.0f * static_cast<float>(i) / static_cast<float>(cells) - 1.0f);
  };
  for (uint32_t z = 0; z <= cells; ++z)
    for (uint32_t x = 0; x <= cells; ++x) positions.emplace_back(place(x), 0.0f, place(z));
  for (uint32_t z = 0; z < cells; ++z)
    for (uint32_t x = 0; x < cells; ++x) {
      const uint32_t p = z * (cells + 1) + x, q = p + cells + 1;
      triangles.push_back({p, q, q + 1});
      triangles.push_back({p, q + 1, p + 1});
    }
  return make_scene(positions, triangles, {point_light({0, 3, 0})});
}

// Small, medium and huge triangles, some of which the near plane cuts: every pixel that looks down shows one.
TEST_F(Raster, LeavesNoHoleBetweenNeighbours) {
  for (const uint32_t cells : {1u, 2u, 13u, 90u, 400u}) {
    Drawn drawn(floor_of(cells, 50.0f), "gbuffer_compute");
    for (const float height : {0.12f, 0.4f, 3.0f, 20.0f}) {
      CameraView camera = look_at({0.3f, height, 0.2f}, {0.31f + 0.3f * height, 0, 0.5f * height}, 0.9f, 400, 300);
      camera.near_plane = 0.05f;
      const Picture picture = drawn.look(camera, 400, 300);
      const auto holes =
          std::count_if(picture.at.begin(), picture.at.end(), [](const auto& s) { return s.triangle == 0; });
      EXPECT_EQ(holes, 0) << cells << " cells, from " << height;
    }
  }
}

// Of such a picture no triangle is divided (gpu/passes/gbuffer_compute.cpp, kMostTiles).
TEST_F(Raster, LeavesNoHoleInAPictureOfMoreTilesThanItDivides) {
  constexpr uint32_t kWidth = 4096, kHeight = 2200;
  Drawn drawn(floor_of(13, 50.0f), "gbuffer_compute");
  const Picture picture =
      drawn.look(look_at({0.3f, 3, 0.2f}, {1, 0, 1.5f}, 0.9f, kWidth, kHeight), kWidth, kHeight);
  EXPECT_EQ(std::count_if(picture.at.begin(), picture.at.end(), [](const auto& s) { return s.triangle == 0; }), 0);
}

// Some 45,000 triangles of 9x9 pixels: of lists that long, the last are drawn whole (shaders/raster.glsl, kMostDivided).
TEST_F(Raster, DrawsMoreLargeTrianglesThanItDivides) {
  const auto scene = floor_of(150, 50.0f);
  Drawn hardware(scene, "gbuffer_all"), compute(scene, "gbuffer_compute");
  const CameraView camera = look_at({0.3f, 100, 0.2f}, {0.4f, 0, 0.6f}, 0.9f, 1400, 1400);
  const Picture picture = compute.look(camera, 1400, 1400);
  std::vector<uint32_t> shown;
  for (const SurfaceSample& sample : picture.at) shown.push_back(sample.triangle);
  std::sort(shown.begin(), shown.end());
  EXPECT_GT(std::unique(shown.begin(), shown.end()) - shown.begin(), 40'000);
  const Difference d = compare(hardware.look(camera, 1400, 1400), picture, camera);
  EXPECT_EQ(d.surfaces, d.pixels);
  EXPECT_EQ(d.unexplained, 0u);
  EXPECT_LE(d.edges + d.ties, d.pixels / 100);
}

}  // namespace
}  // namespace gnomon::test
