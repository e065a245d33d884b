// The occlusion of ambient light against a test of every triangle in C++, over the very same surface and segments: no
// plane of any pixel may differ, and no valid bit.
#include <gtest/gtest.h>

#include "scenes/light_samples.h"
#include "tests/unit/gpu/brute_force.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;
using namespace std::chrono_literals;
using scenes::SceneTime;

constexpr uint32_t kWidth = 101, kHeight = 61;  // no multiples of the tile size, and odd

CameraView camera() { return look_at({0.5f, 0.6f, 2.2f}, {0.5f, 0.5f, 0.5f}, 0.8f, kWidth, kHeight); }

OcclusionCount expect_exact(SurfaceProbe& probe, const scenes::Scene& scene, SampleCounts samples,
                            SceneTime time = {}) {
  const auto frame = probe.render(camera(), kWidth, kHeight, time, samples);
  EXPECT_TRUE(frame) << frame.error().message;
  if (!frame) return {};
  EXPECT_EQ(frame->grid.planes, planes_of(scene, samples).total());
  const auto stopped = scenes::frozen_at(scene, time);
  const OcclusionCount count = compare_occlusion(*stopped, camera(), *frame);
  EXPECT_EQ(count.differing, 0u) << probe.tracer().name() << ", of " << count.counted;
  if (probe.tracer().name() != "ray_query") {
    EXPECT_EQ(compare_soft(*stopped, camera(), *frame).differing, 0u) << "lights beside it";
  }
  return count;
}

scenes::ScenePtr reaching(const scenes::Scene& scene, float reach) {
  auto copy = std::make_shared<scenes::Scene>(scene);
  copy->surroundings.ambient_reach = reach;
  return copy;
}

class OcclusionIn : public testing::TestWithParam<uint32_t> {};

TEST_P(OcclusionIn, EqualBruteForce) {
  const uint32_t seed = GetParam();
  const auto scene = reaching(*with_areas(*triangle_soup(seed, 30 + 60 * seed, 3), 0.1f), 0.3f * float(seed));
  for (const std::string& tracer : tracers()) {
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    for (const uint32_t per_light : {1u, 4u}) {
      const OcclusionCount full = expect_exact(*probe, *scene, {per_light, Occlusion::full});
      EXPECT_GT(full.open, 50u);
      EXPECT_GT(full.partly, 200u);
      const OcclusionCount half = expect_exact(*probe, *scene, {per_light, Occlusion::half});
      EXPECT_NEAR(double(half.counted), double(full.counted) / 4, double(full.counted) / 40);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, OcclusionIn, testing::Range(2u, 6u));

// What moves occludes, and is occluded.
TEST(Occlusion, FollowsWhatMoves) {
  const auto scene = reaching(*swinging_soup(2, WhatMoves{true, true}), 0.5f);
  for (const std::string& tracer : tracers()) {
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    for (const SceneTime time : {SceneTime(0), SceneTime(430ms), SceneTime(1s)})
      EXPECT_GT(expect_exact(*probe, *scene, {1, Occlusion::full}, time).partly, 200u);
  }
}

// Frames with and without it follow each other in one slot.
TEST(Occlusion, LeavesTheLightsAsTheyAre) {
  const auto scene = triangle_soup(4, 200, 5);
  for (const std::string& tracer : tracers()) {
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    const auto before = probe->render(camera(), kWidth, kHeight);
    const auto with = probe->render(camera(), kWidth, kHeight, {}, {1, Occlusion::full});
    const auto after = probe->render(camera(), kWidth, kHeight);
    ASSERT_TRUE(before && with && after);
    EXPECT_EQ(before->words, after->words);
    ASSERT_GT(with->words.size(), before->words.size());
    EXPECT_TRUE(std::equal(before->words.begin(), before->words.end(), with->words.begin()));
  }
}

// A surface that nothing is near is open throughout; at the foot of a wall that is higher than the reach, half of the
// hemisphere is hidden, and a share of the segments' points to match.
TEST(Occlusion, IsNothingInTheOpenAndHalfAtTheFootOfAWall) {
  const auto made = make_scene(
      {{-9, 0, -9}, {9, 0, -9}, {9, 0, 9}, {-9, 0, 9}, {0.5f, -1, -9}, {0.5f, 9, -9}, {0.5f, 9, 9}, {0.5f, -1, 9}},
      {{0, 2, 1}, {0, 3, 2}, {4, 5, 6}, {4, 6, 7}}, {point_light({0, 5, 0})});
  const auto scene = reaching(*made, 1.0f);
  auto probe = SurfaceProbe::create(device_options(tracers().front()), scene);
  ASSERT_TRUE(probe) << probe.error().message;
  const CameraView from = look_at({-0.5f, 2.0f, 0.001f}, {-0.5f, 0.0f, 0.0f}, 1.4f, 160, 160);
  const auto frame = probe->render(from, 160, 160, {}, {1, Occlusion::full});
  ASSERT_TRUE(frame) << frame.error().message;
  const LightPlanes planes = planes_of(*scene, frame->counts);
  double foot = 0, foot_pixels = 0;
  for (uint32_t y = 0; y < 160; ++y)
    for (uint32_t x = 0; x < 160; ++x) {
      const SurfaceSample& sample = frame->surface_at(x, y);
      if (sample.triangle == 0 || sample.normal.y < 0.9f) continue;
      const uint32_t open = planes.open_segments(frame->mask(), x, y);
      const float away = 0.5f - sample.position.x;
      if (away > 0.51f) {
        EXPECT_EQ(open, kOcclusionSegments) << away << ": the sphere's radius is half of the reach";
      }
      if (away > 0.0f && away < 0.02f) {
        foot += open;
        ++foot_pixels;
      }
    }
  ASSERT_GT(foot_pixels, 30);
  EXPECT_NEAR(foot / foot_pixels / kOcclusionSegments, 0.5, 0.05);
}

}  // namespace
}  // namespace gnomon::test
