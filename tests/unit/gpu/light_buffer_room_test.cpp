// What light buffers may take where nothing is configured, by the device.
#include <gtest/gtest.h>

#include "gpu/tracers/light_buffer/builder.h"
#include "gpu/tracers/tracer_options.h"

namespace gnomon::test {
namespace {

using gpu::light_buffer::default_budget;

constexpr uint64_t kMebi = 1 << 20, kGibi = 1024 * kMebi;

gpu::PhysicalDevice gpu_with(uint64_t local_bytes) {
  gpu::PhysicalDevice device;
  device.type = VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU;
  device.local_bytes = local_bytes;
  return device;
}

uint64_t budget_on(const gpu::PhysicalDevice& device, const gpu::TracerOptions& options = {}) {
  return default_budget(2, gpu::light_buffer_room(device, options));
}

TEST(LightBufferRoom, IsAPartOfALargeGpu) {
  EXPECT_EQ(budget_on(gpu_with(64 * kGibi)), kGibi);
  EXPECT_EQ(budget_on(gpu_with(140 * kGibi)), 1280 * kMebi) << "more has not been of use";
}

TEST(LightBufferRoom, IsNeverLessThanTheLightsAskFor) {
  EXPECT_EQ(budget_on(gpu_with(0)), 224 * kMebi);
  EXPECT_EQ(budget_on(gpu_with(8 * kGibi)), 224 * kMebi);
  EXPECT_EQ(default_budget(40, 300 * kMebi), 512 * kMebi);
}

TEST(LightBufferRoom, IsNoneOnAProcessorWhoseMemoryEverythingShares) {
  gpu::PhysicalDevice processor = gpu_with(140 * kGibi);
  processor.type = VK_PHYSICAL_DEVICE_TYPE_CPU;
  EXPECT_EQ(budget_on(processor), 224 * kMebi);
}

TEST(LightBufferRoom, IsLimitedByTheOptions) {
  gpu::TracerOptions options;
  options.most_light_buffer_room = 400 * kMebi;
  EXPECT_EQ(budget_on(gpu_with(140 * kGibi), options), 400 * kMebi);
  options.most_light_buffer_room = 0;
  EXPECT_EQ(budget_on(gpu_with(140 * kGibi), options), 224 * kMebi);
}

}  // namespace
}  // namespace gnomon::test
