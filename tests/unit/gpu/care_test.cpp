// The valid bits of a frame are exactly those of the segments that exact.glsl traces, for every tracer.
#include <gtest/gtest.h>

#include "gpu/scene/resident_scene.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

constexpr uint32_t kWidth = 100, kHeight = 60;  // no multiples of the tile size

bool traced(const CameraView& camera, const SurfaceSample& sample, const exact::TracedLight& light) {
  return sample.triangle != 0 &&
         exact::shadow_segment(camera.position, {sample.position, sample.normal}, light).traced;
}

TEST(Care, IsWhatIsTraced) {
  const auto scene = triangle_soup(11, 300, 40);  // lights of every kind, more than are packed at a time
  const CameraView camera = look_at({0.5f, 0.6f, 2.2f}, {0.5f, 0.5f, 0.5f}, 0.8f, kWidth, kHeight);
  for (const std::string& tracer : tracers()) {
    SCOPED_TRACE(tracer);
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    const auto frame = probe->render(camera, kWidth, kHeight);
    ASSERT_TRUE(frame) << frame.error().message;
    size_t cared = 0, differing = 0;
    for (uint32_t i = 0; i < frame->grid.planes; ++i)
      for (uint32_t y = 0; y < kHeight; ++y)
        for (uint32_t x = 0; x < kWidth; ++x) {
          const bool expected =
              traced(camera, frame->samples[size_t{y} * kWidth + x], traced_light(scene->lights[i], scene->bounds));
          cared += expected;
          differing += expected != frame->care().lit(x, y, i);
        }
    EXPECT_EQ(differing, 0u);
    EXPECT_GT(cared, 1000u);
    EXPECT_LT(cared, frame->grid.planes * size_t{kWidth} * kHeight / 2);
  }
}

TEST(Care, MasksAreZeroElsewhereAndBeyondThePicture) {
  const auto scene = triangle_soup(12, 300, 8);
  const CameraView camera = look_at({0.5f, 0.6f, 2.2f}, {0.5f, 0.5f, 0.5f}, 0.8f, kWidth, kHeight);
  for (const std::string& tracer : tracers()) {
    SCOPED_TRACE(tracer);
    auto probe = SurfaceProbe::create(device_options(tracer), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    const auto frame = probe->render(camera, kWidth, kHeight);
    ASSERT_TRUE(frame) << frame.error().message;
    const uint32_t tiles_x = frame->grid.tiles_x(), tiles = frame->grid.tile_count();
    for (size_t i = 0; i < frame->words.size(); ++i) {
      const uint64_t care = frame->valid_bits[i];
      ASSERT_EQ(frame->words[i] & ~care, 0u) << "word " << i;
      const bool right = i % tiles_x == tiles_x - 1, below = i % tiles >= tiles - tiles_x;
      const uint64_t beyond = (right ? 0xf0f0f0f0f0f0f0f0 : 0) | (below ? 0xffffffff00000000 : 0);
      ASSERT_EQ(care & beyond, 0u) << "word " << i;
    }
  }
}

}  // namespace
}  // namespace gnomon::test
