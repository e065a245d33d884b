// The GPU packs masks as common/packed_mask.h does: the same classes, and the same words in the same order.
#include <gtest/gtest.h>

#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

struct Bytes {
  size_t packed = 0, whole = 0;
};

// One frame, packed on the GPU and on the CPU.
Bytes compare(BlockingFrame& frame, uint32_t width, uint32_t height) {
  const CameraView camera = look_at({0.5f, 0.6f, 2.2f}, {0.5f, 0.5f, 0.5f}, 0.8f, width, height);
  const auto grid = frame.reserve(width, height);
  EXPECT_TRUE(grid) << grid.error().message;
  EXPECT_TRUE(frame.render(camera, *grid));
  const auto words_of = [&](std::string_view resource) {
    return std::span(reinterpret_cast<const uint64_t*>(frame.host(resource).data()), grid->word_count());
  };
  const PackedMask here({*grid, words_of(resource::kHostMasks)}, words_of(resource::kHostValidBits));
  const PackedMaskView expected = here.view(), packed = frame.packed(*grid);
  EXPECT_TRUE(
      std::equal(packed.classes.begin(), packed.classes.end(), expected.classes.begin(), expected.classes.end()));
  EXPECT_TRUE(std::equal(packed.mixed.begin(), packed.mixed.end(), expected.mixed.begin(), expected.mixed.end()));
  return {packed.bytes(), words_of(resource::kHostMasks).size_bytes()};
}

std::unique_ptr<BlockingFrame> packing(const scenes::ScenePtr& scene) {
  auto frame = BlockingFrame::create(
      device_options(), {"gbuffer", "trace", "pack", "readback", "readback_masks", "readback_valid_bits"}, scene);
  EXPECT_TRUE(frame) << frame.error().message;
  return std::move(*frame);
}

TEST(Pack, EqualsPackingOnTheCpu) {
  for (const uint32_t lights : {1u, 3u, 37u}) {
    auto frame = packing(triangle_soup(lights, 400, lights));
    // Sizes go up and down through one slot; the numbers of words are not multiples of a group's.
    for (const auto& [width, height] : {std::pair{100u, 60u}, {333u, 187u}, {8u, 8u}, {1u, 1u}, {640u, 360u}}) {
      SCOPED_TRACE(testing::Message() << lights << " lights, " << width << "x" << height);
      compare(*frame, width, height);
    }
  }
}

TEST(Pack, ScenesWithoutLightsOrTrianglesHaveNoWords) {
  EXPECT_EQ(compare(*packing(triangle_soup(1, 10, 0)), 100, 60).packed, 0u);
  const Bytes empty = compare(*packing(triangle_soup(1, 0, 2)), 100, 60);
  EXPECT_EQ(empty.packed, (empty.whole / 8 + 15) / 16 * 4) << "classes alone";
}

TEST(Pack, LeavesMostBehind) {
  auto frame = packing(square_over_floor(point_light({0.7f, 3.0f, -0.4f})));
  const auto grid = frame->reserve(640, 360);
  ASSERT_TRUE(grid);
  ASSERT_TRUE(frame->render(look_at({3, 4, 5}, {0, 0, 0}, 0.9f, 640, 360), *grid));
  const PackedMaskView packed = frame->packed(*grid);
  EXPECT_GT(packed.mixed.size(), 10u);
  EXPECT_LT(packed.bytes(), grid->word_count() * sizeof(uint64_t) / 8);
}

}  // namespace
}  // namespace gnomon::test
