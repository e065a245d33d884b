// Soft shadows against a test of every triangle in C++, over the very same surface and sample points: no plane of any
// pixel may differ, and no valid bit.
#include <gtest/gtest.h>

#include "tests/unit/gpu/brute_force.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;
using namespace std::chrono_literals;
using scenes::SceneTime;

constexpr uint32_t kWidth = 100, kHeight = 60;  // no multiples of the tile size

CameraView camera() { return look_at({0.5f, 0.6f, 2.2f}, {0.5f, 0.5f, 0.5f}, 0.8f, kWidth, kHeight); }

// What lights without an extent may differ by: the rounding of a device's own ray queries.
SoftCount expect_exact(SurfaceProbe& probe, const scenes::Scene& scene, const CameraView& from, uint32_t samples,
                       SceneTime time = {}) {
  const auto frame = probe.render(from, kWidth, kHeight, time, samples);
  EXPECT_TRUE(frame) << frame.error().message;
  if (!frame) return {};
  EXPECT_EQ(frame->grid.planes, planes_of(scene, samples).total());
  const SoftCount count = compare_soft(*scenes::frozen_at(scene, time), from, *frame);
  const size_t allowed = probe.tracer().name() == "ray_query" ? count.asked / 1000 : 0;
  EXPECT_LE(count.differing, allowed) << probe.tracer().name() << ", " << samples << " samples, of " << count.asked;
  return count;
}

class SoftSoups : public testing::TestWithParam<uint32_t> {};

TEST_P(SoftSoups, EqualBruteForce) {
  const uint32_t seed = GetParam();
  const float reach = seed % 3 == 0 ? 0.6f : seed % 3 == 1 ? 0.1f : 0.01f;
  const auto scene = with_areas(*triangle_soup(seed, 30 + 60 * seed, 5), reach);
  for (const std::string& tracer : tracers()) {
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    for (const bool built : {false, true}) {
      if (built) {
        ASSERT_TRUE(probe->build_areas());
      }
      for (const uint32_t samples : {4u, 16u}) {
        const SoftCount count = expect_exact(*probe, *scene, camera(), samples);
        EXPECT_GT(count.lit, 50u);
        EXPECT_GT(count.dark, 50u);
        EXPECT_GT(count.penumbrae, reach < 0.05f ? 20u : 200u);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, SoftSoups, testing::Range(1u, 7u));

TEST(Soft, EqualsBruteForceFarFromTheOrigin) {
  const auto near = with_areas(*triangle_soup(5, 200, 4), 0.3f);
  auto far = std::make_shared<scenes::Scene>(*near);
  const glm::vec3 shift(3000.0f, -500.0f, 1700.0f);
  for (glm::vec3& p : far->meshes[0].primitives[0].positions) p += shift;
  for (scenes::Light& light : far->lights) light.position += shift;
  far->bounds = {near->bounds.min + shift, near->bounds.max + shift};
  for (const std::string& tracer : tracers()) {
    auto probe = SurfaceProbe::create(device_options(tracer), far);
    ASSERT_TRUE(probe) << probe.error().message;
    const CameraView from = look_at(shift + glm::vec3(0.5f, 0.6f, 2.2f), shift + 0.5f, 0.8f, kWidth, kHeight);
    EXPECT_GT(expect_exact(*probe, *far, from, 16).lit, 100u);
    ASSERT_TRUE(probe->build_areas());
    EXPECT_GT(expect_exact(*probe, *far, from, 16).lit, 100u);
  }
}

// Frames with and without soft shadows follow each other in one slot.
TEST(Soft, AHardFrameIsAsItIsWithoutAreas) {
  const auto plain = triangle_soup(4, 200, 5);
  for (const std::string& tracer : tracers()) {
    auto hard = SurfaceProbe::create(device_options(tracer), plain);
    auto soft = SurfaceProbe::create(device_options(tracer), with_areas(*plain, 0.2f));
    ASSERT_TRUE(hard && soft);
    const auto a = hard->render(camera(), kWidth, kHeight, {}, 16);  // has no area lights
    ASSERT_TRUE(soft->render(camera(), kWidth, kHeight, {}, 4));
    const auto b = soft->render(camera(), kWidth, kHeight);
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->grid.planes, 5u);
    EXPECT_EQ(a->words, b->words);
    EXPECT_EQ(a->valid_bits, b->valid_bits);
  }
}

// Lights that move have planes that move with them, and what moves hides some of their points.
class SoftMotion : public testing::TestWithParam<WhatMoves> {};

TEST_P(SoftMotion, MasksAreThoseOfTheSceneStopped) {
  const auto scene = with_areas(*swinging_soup(2, GetParam()), 0.25f);
  for (const std::string& tracer : tracers()) {
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    for (const SceneTime time : {SceneTime(0), SceneTime(430ms), SceneTime(1s)}) {
      if (time == SceneTime(430ms)) {
        ASSERT_TRUE(probe->build_areas());
      }
      EXPECT_GT(expect_exact(*probe, *scene, camera(), 4, time).penumbrae, 200u);
      EXPECT_GT(expect_exact(*probe, *scene, camera(), 16, time).penumbrae, 200u);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(What, SoftMotion,
                         testing::Values(WhatMoves{true, false}, WhatMoves{false, true}, WhatMoves{true, true}),
                         [](const auto& test) {
                           return std::string(test.param.body ? "Body" : "") + (test.param.light ? "Light" : "");
                         });

TEST(Soft, LightsThatWereMovedAndResizedAreExact) {
  for (const std::string& tracer : tracers()) {
    auto scene = std::make_shared<scenes::Scene>(*with_areas(*triangle_soup(5, 200, 4), 0.2f));
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    ASSERT_TRUE(probe->build_areas());
    expect_exact(*probe, *scene, camera(), 16);
    scene->lights[0].position += glm::vec3(0.2f, 0.1f, -0.1f);
    scene->lights[1].area.u *= 1.5f;
    ASSERT_TRUE(probe->set_lights(scene->lights));
    expect_exact(*probe, *scene, camera(), 16);
    ASSERT_TRUE(probe->rebuild());
    ASSERT_TRUE(probe->build_areas());
    expect_exact(*probe, *scene, camera(), 16);
  }
}

}  // namespace
}  // namespace gnomon::test
