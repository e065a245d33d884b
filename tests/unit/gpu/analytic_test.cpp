// Shadows known without tracing: a square over a floor.
#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWidth = 320, kHeight = 200;
// Metres on the floor around the edges of the shadow and of the cone, which the offset of the segments' origins moves.
constexpr float kMargin = 0.002f;

// Where the segment from the floor point to the light passes the square's height.
glm::vec2 passing(const scenes::Light& light, glm::vec3 floor) {
  glm::vec3 to_light = light.position - floor;
  if (light.type == scenes::LightType::directional) to_light = -light.direction;
  const glm::vec3 at = floor + to_light * ((1.0f - floor.y) / to_light.y);
  return {at.x, at.z};
}

// Lit, dark, or undecided, because the point is too near to an edge.
std::optional<bool> expected(const scenes::Light& light, glm::vec3 floor) {
  const glm::vec2 p = glm::abs(passing(light, floor));
  const float out = std::max(p.x, p.y) - 0.5f;
  if (std::abs(out) < kMargin) return std::nullopt;
  if (out < 0) return false;
  if (light.type == scenes::LightType::spot) {
    const float cone = glm::dot(glm::normalize(floor - light.position), light.direction) - light.outer_cone_cos;
    if (std::abs(cone) < kMargin) return std::nullopt;
    if (cone < 0) return false;
  }
  if (light.range > 0) {
    const float beyond = glm::distance(floor, light.position) - light.range;
    if (std::abs(beyond) < kMargin) return std::nullopt;
    if (beyond > 0) return false;
  }
  return true;
}

void check(const scenes::Light& light) {
  const auto scene = square_over_floor(light);
  for (const std::string& tracer : tracers()) {
    SCOPED_TRACE(tracer);
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    const CameraView camera = look_at({3.0f, 4.0f, 5.0f}, {0, 0, 0}, 0.9f, kWidth, kHeight);
    const auto frame = probe->render(camera, kWidth, kHeight);
    ASSERT_TRUE(frame) << frame.error().message;
    size_t lit = 0, dark = 0, wrong = 0;
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        const SurfaceSample& s = frame->samples[size_t{y} * kWidth + x];
        if (s.triangle == 0 || s.triangle > 2) continue;  // the floor's two triangles come first
        const auto answer = expected(light, s.position);
        if (!answer) continue;
        ++(*answer ? lit : dark);
        wrong += *answer != frame->mask().lit(x, y, 0);
      }
    EXPECT_EQ(wrong, 0u);
    EXPECT_GT(lit, 1000u);
    EXPECT_GT(dark, 300u);
  }
}

TEST(AnalyticShadow, OfAPointLight) { check(point_light({0.7f, 3.0f, -0.4f})); }
TEST(AnalyticShadow, OfADirectionalLight) { check(sun({0.4f, -1.0f, 0.2f})); }
TEST(AnalyticShadow, OfASpotLight) { check(spot_light({0.2f, 3.0f, 0.1f}, {0.05f, -1.0f, 0.0f}, 0.8f)); }
TEST(AnalyticShadow, OfALightWithARange) {
  scenes::Light light = point_light({0.0f, 2.0f, 0.0f});
  light.range = 2.6f;
  check(light);
}

// What shows no surface, and what lies beyond the picture in the last tiles, is 0.
TEST(AnalyticShadow, BitsWithoutSurfaceAreZero) {
  const auto scene = square_over_floor(point_light({0, 3, 0}));
  constexpr uint32_t width = 61, height = 43;
  auto probe = SurfaceProbe::create(device_options("bvh"), scene);
  ASSERT_TRUE(probe) << probe.error().message;
  const auto frame = probe->render(look_at({0, 6, 9}, {0, 0, 0}, 1.2f, width, height), width, height);
  ASSERT_TRUE(frame) << frame.error().message;
  size_t empty = 0;
  const TileGrid& grid = frame->grid;
  for (uint32_t y = 0; y < grid.tiles_y() * kTileSize; ++y)
    for (uint32_t x = 0; x < grid.tiles_x() * kTileSize; ++x) {
      const bool inside = x < width && y < height;
      if (inside && frame->samples[size_t{y} * width + x].triangle != 0) continue;
      ++empty;
      EXPECT_FALSE(frame->mask().lit(x, y, 0)) << x << "," << y;
    }
  EXPECT_GT(empty, 500u);
}

// Off-centre frusta: the same pixel of a shifted window sees the same surface.
TEST(AnalyticShadow, AFrustumMayBeAsymmetric) {
  const auto scene = square_over_floor(point_light({0.7f, 3.0f, -0.4f}));
  auto probe = SurfaceProbe::create(device_options("bvh"), scene);
  ASSERT_TRUE(probe) << probe.error().message;
  CameraView whole = look_at({3.0f, 4.0f, 5.0f}, {0, 0, 0}, 0.9f, 256, 256);
  whole.tan_left = whole.tan_right = whole.tan_up = whole.tan_down = 0.5f;
  CameraView quarter = whole;  // the upper right one
  quarter.tan_left = quarter.tan_down = 0.0f;
  const auto all = probe->render(whole, 256, 256);
  ASSERT_TRUE(all) << all.error().message;
  const auto part = probe->render(quarter, 128, 128);
  ASSERT_TRUE(part) << part.error().message;
  size_t same = 0, surfaces = 0;
  for (uint32_t y = 0; y < 128; ++y)
    for (uint32_t x = 0; x < 128; ++x) {
      const SurfaceSample& a = all->samples[size_t{y} * 256 + x + 128];
      const SurfaceSample& b = part->samples[size_t{y} * 128 + x];
      if (a.triangle == 0 || b.triangle == 0) continue;
      ++surfaces;
      same += a.triangle == b.triangle && glm::distance(a.position, b.position) < 1e-4f;
    }
  EXPECT_GT(surfaces, 5000u);
  EXPECT_GE(same, surfaces * 999 / 1000);
}

}  // namespace
}  // namespace gnomon::test
