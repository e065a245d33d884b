// Geometry with an alpha test blocks light, and is seen, only where its texture is solid.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWidth = 320, kHeight = 200, kCells = 8;
constexpr float kMargin = 0.003f;

struct Check {
  bool solid;
  bool near_edge;
};

// The check of the square |x|, |z| < 1 that point (x, z) lies in.
Check check_at(glm::vec2 p) {
  const glm::vec2 cell = (p * 0.5f + 0.5f) * static_cast<float>(kCells);
  const glm::vec2 to_edge = glm::abs(cell - glm::round(cell)) * (2.0f / static_cast<float>(kCells));
  const int x = static_cast<int>(std::floor(cell.x)), y = static_cast<int>(std::floor(cell.y));
  const bool inside = std::abs(p.x) < 1.0f && std::abs(p.y) < 1.0f;
  return {inside && (x + y) % 2 == 0, std::min(to_edge.x, to_edge.y) < kMargin};
}

TEST(AlphaMask, CastsTheShadowOfItsTexture) {
  const scenes::Light light = point_light({0.3f, 3.0f, 0.2f});
  const auto scene = checks_over_floor(light, kCells, scenes::AlphaMode::mask);
  for (const std::string& tracer : tracers()) {
    SCOPED_TRACE(tracer);
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    const auto frame = probe->render(look_at({3, 2, 4}, {0, 0, 0}, 0.9f, kWidth, kHeight), kWidth, kHeight);
    ASSERT_TRUE(frame) << frame.error().message;
    size_t lit = 0, dark = 0, wrong = 0, seen = 0, seen_wrong = 0;
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        const SurfaceSample& s = frame->samples[size_t{y} * kWidth + x];
        if (s.triangle == 0) continue;
        if (s.triangle > 2) {  // the square itself
          ++seen;
          const Check check = check_at({s.position.x, s.position.z});
          seen_wrong += !check.solid && !check.near_edge;
          continue;
        }
        const glm::vec3 to_light = light.position - s.position;
        const glm::vec3 at = s.position + to_light / to_light.y;
        const Check check = check_at({at.x, at.z});
        if (check.near_edge) continue;
        ++(check.solid ? dark : lit);
        wrong += check.solid == frame->mask().lit(x, y, 0);
      }
    EXPECT_EQ(wrong, 0u);
    EXPECT_EQ(seen_wrong, 0u);
    EXPECT_GT(lit, 1000u);
    EXPECT_GT(dark, 300u);
    EXPECT_GT(seen, 300u);
  }
}

TEST(AlphaBlend, BlocksNothingAndIsNotSeen) {
  const auto scene = checks_over_floor(point_light({0.3f, 3.0f, 0.2f}), kCells, scenes::AlphaMode::blend);
  for (const std::string& tracer : tracers()) {
    SCOPED_TRACE(tracer);
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    const auto frame = probe->render(look_at({3, 2, 4}, {0, 0, 0}, 0.9f, kWidth, kHeight), kWidth, kHeight);
    ASSERT_TRUE(frame) << frame.error().message;
    size_t surfaces = 0;
    for (uint32_t y = 0; y < kHeight; ++y)
      for (uint32_t x = 0; x < kWidth; ++x) {
        const SurfaceSample& s = frame->samples[size_t{y} * kWidth + x];
        if (s.triangle == 0) continue;
        ++surfaces;
        ASSERT_LE(s.triangle, 2u);
        ASSERT_TRUE(frame->mask().lit(x, y, 0)) << x << "," << y;
      }
    EXPECT_GT(surfaces, 5000u);
  }
}

}  // namespace
}  // namespace gnomon::test
