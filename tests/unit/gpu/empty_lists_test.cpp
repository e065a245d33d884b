// Scenes of which nothing shows. Shaders read the first element of a list before they know whether there is one: what
// they find there was written too, whatever the memory held before.
#include <gtest/gtest.h>

#include <algorithm>

#include "gpu/vulkan/resources.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

std::vector<std::byte> content_of(const DevicePtr& device, const Buffer& buffer) {
  const auto copy = Buffer::create(device, buffer.bytes(), VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::readback);
  EXPECT_TRUE(copy);
  const auto copied = run_now(device, [&](VkCommandBuffer commands) {
    const VkBufferCopy all{0, 0, buffer.bytes()};
    vkCmdCopyBuffer(commands, buffer.handle(), copy->handle(), 1, &all);
  });
  EXPECT_TRUE(copied);
  const auto* bytes = static_cast<const std::byte*>(copy->mapped());
  return {bytes, bytes + buffer.bytes()};
}

TEST(EmptyLists, AreZerosWhereOthersWere) {
  const auto device = Device::create({});
  ASSERT_TRUE(device) << device.error().message;
  const std::vector<std::byte> ones(4096, std::byte{0xff});
  const auto stays =
      upload(*device, ones, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);  // so that the memory is not given back
  ASSERT_TRUE(stays);
  for (int i = 0; i < 8; ++i) ASSERT_TRUE(upload(*device, ones));
  (*device)->collect();
  const auto none = upload(*device, {}, VK_BUFFER_USAGE_TRANSFER_SRC_BIT);
  ASSERT_TRUE(none);
  EXPECT_GE(none->bytes(), kNoElementBytes);
  EXPECT_EQ(content_of(*device, *none), std::vector<std::byte>(none->bytes()));
}

class NothingShows : public testing::TestWithParam<std::string> {};

TEST_P(NothingShows, NoPairOfPixelAndLightIsTraced) {
  const auto scene =
      make_scene({}, {}, {point_light({1, 2, 3}), sun({0, -1, 0}), spot_light({0, 3, 0}, {0, -1, 0}, 0.5f)});
  auto probe = SurfaceProbe::create(device_options(GetParam()), scene);
  ASSERT_TRUE(probe) << probe.error().message;
  const auto frame = probe->render(look_at({3, 4, 5}, {0, 0, 0}, 0.9f, 61, 43), 61, 43);
  ASSERT_TRUE(frame) << frame.error().message;
  EXPECT_TRUE(
      std::all_of(frame->valid_bits.begin(), frame->valid_bits.end(), [](uint64_t word) { return word == 0; }));
}

INSTANTIATE_TEST_SUITE_P(EmptyLists, NothingShows, testing::ValuesIn(tracers()));

}  // namespace
}  // namespace gnomon::test
