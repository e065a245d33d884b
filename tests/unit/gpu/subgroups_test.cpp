// Light buffers with subgroups of any size: the shader in use is the one that the run is for, and gives brute force's
// bits.
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <map>

#include "gpu/tracers/light_buffer_shaders.h"
#include "tests/unit/gpu/brute_force.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

// The size of subgroups that the run is for; 0: any.
uint32_t lanes_of_run() { return number_in_environment("GNOMON_TEST_LANES"); }
uint32_t emulated_lanes() { return number_in_environment("GNOMON_TEST_EMULATED_LANES"); }

bool has_vectors_of(uint32_t lanes) {
#if defined(__x86_64__)
  return lanes < 16 || __builtin_cpu_supports("avx512f");
#else
  return lanes < 8;
#endif
}

// Ends a run that is for subgroups that nothing here has, with the exit status that ctest takes for skipped.
class DeviceOfRun : public testing::Environment {
 public:
  void SetUp() override {
    const uint32_t lanes = lanes_of_run();
    if (lanes == 0) return;
    if (!has_vectors_of(lanes)) skip("this processor's vectors are narrower");
    const auto device = Device::create({device_options().device, {}});
    if (!device || (*device)->info().type == VK_PHYSICAL_DEVICE_TYPE_CPU) return;
    if ((*device)->features().subgroups.usual != lanes) skip("the device is no processor, and has others");
  }

 private:
  [[noreturn]] static void skip(const char* why) {
    std::printf("skipped: no subgroups of %u lanes here: %s\n", lanes_of_run(), why);
    std::exit(77);
  }
};
const testing::Environment* const device_of_run = testing::AddGlobalTestEnvironment(new DeviceOfRun);

// The invocations of a workgroup, of which the module has one kind.
uint32_t invocations(std::span<const uint32_t> spirv) {
  constexpr uint32_t kHeader = 5, kExecutionMode = 16, kConstant = 43, kExecutionModeId = 331;
  constexpr uint32_t kLocalSize = 17, kLocalSizeId = 38;
  std::map<uint32_t, uint32_t> constants;
  uint32_t size = 0, id = 0;
  for (size_t i = kHeader; i < spirv.size(); i += spirv[i] >> 16) {
    const uint32_t operation = spirv[i] & 0xffff;
    if (operation == kConstant) constants[spirv[i + 2]] = spirv[i + 3];
    if (operation == kExecutionMode && spirv[i + 2] == kLocalSize) size = spirv[i + 3];
    if (operation == kExecutionModeId && spirv[i + 2] == kLocalSizeId) id = spirv[i + 3];
  }
  return id ? constants[id] : size;
}

bool offers_light_buffers() {
  for (const std::string& tracer : tracers())
    if (tracer == "light_buffer") return true;
  return false;
}

TEST(Subgroups, LightBuffersAreTracedByThoseOfTheRun) {
  if (lanes_of_run() == 0 && emulated_lanes() == 0) GTEST_SKIP() << "the run is for subgroups of any size";
  ASSERT_TRUE(offers_light_buffers());
  auto probe = SurfaceProbe::create(device_options(), triangle_soup(1, 100, 2));
  ASSERT_TRUE(probe) << probe.error().message;
  EXPECT_EQ(probe->tracer().name(), "light_buffer");
  const TraceShader shader = probe->tracer().shader();
  if (emulated_lanes() != 0) {
    EXPECT_EQ(shader.spirv.data(), emulated_light_buffer_shader(emulated_lanes()).spirv.data());
    EXPECT_EQ(invocations(shader.spirv), emulated_lanes());
  } else {
    EXPECT_EQ(probe->device().features().subgroups.usual, lanes_of_run());
    EXPECT_EQ(shader.lanes, lanes_of_run());
  }
}

TEST(Subgroups, ARunWithoutTexelsLoadsNone) {
  if (device_options().texel_loads) GTEST_SKIP() << "the run is with what the device has";
  for (const std::string& tracer : tracers()) {
    SCOPED_TRACE(tracer);
    auto probe = SurfaceProbe::create(device_options(tracer), triangle_soup(1, 100, 2));
    ASSERT_TRUE(probe) << probe.error().message;
    EXPECT_FALSE(probe->device().features().loads_texels());
  }
}

TEST(Subgroups, EachSizeHasItsShader) {
  for (const uint32_t lanes : {4u, 8u, 16u, 32u, 64u, 128u}) {
    SCOPED_TRACE(lanes);
    const auto shader = light_buffer_shader(lanes);
    ASSERT_TRUE(shader);
    EXPECT_EQ(shader->lanes, lanes);
    EXPECT_EQ(shader->tiles, lanes == 128 ? 2u : 1u);
    EXPECT_EQ(invocations(shader->spirv), lanes);
  }
  for (const uint32_t lanes : {0u, 1u, 2u, 256u}) EXPECT_FALSE(light_buffer_shader(lanes)) << lanes;
}

DeviceFeatures with(const SubgroupFeatures& subgroups) {
  DeviceFeatures features;
  features.subgroups = subgroups;
  return features;
}

TEST(Subgroups, VectorUnitsWithLargeViewsLoadTexels) {
  for (const uint32_t lanes : {4u, 8u, 16u, 32u, 64u, 128u}) {
    SCOPED_TRACE(lanes);
    DeviceFeatures features = with({lanes, lanes, lanes, true, true});
    const auto without = light_buffer_shader(features);
    features.max_texels = DeviceFeatures::kEnoughTexels;
    features.max_sets = DeviceFeatures::kSetsOfATrace;
    const auto chosen = light_buffer_shader(features);
    ASSERT_TRUE(without && chosen);
    EXPECT_EQ(without->texel_buffers, 0u);
    EXPECT_EQ(chosen->texel_buffers > 0, lanes <= 16);
    EXPECT_EQ(without->spirv.data() != chosen->spirv.data(), lanes <= 16);
    EXPECT_EQ(invocations(chosen->spirv), lanes);
  }
}

TEST(Subgroups, OfSeveralSizesTheNarrowestFrom16LanesIsRequested) {
  const auto chosen = [](uint32_t usual, uint32_t least, uint32_t most) {
    const auto shader = light_buffer_shader(with({usual, least, most, true, true}));
    return shader ? shader->lanes : 0;
  };
  EXPECT_EQ(chosen(32, 8, 32), 16u) << "as Intel's";
  EXPECT_EQ(chosen(64, 32, 64), 32u) << "as AMD's RDNA";
  EXPECT_EQ(chosen(64, 64, 64), 64u) << "as AMD's GCN";
  EXPECT_EQ(chosen(16, 16, 16), 16u) << "as Mali's";
  EXPECT_EQ(chosen(128, 64, 128), 64u) << "as Adreno's";
  EXPECT_EQ(chosen(128, 128, 128), 128u) << "as Adreno's without requests";
  EXPECT_EQ(chosen(32, 32, 32), 32u) << "as NVIDIA's";
  EXPECT_EQ(chosen(4, 4, 4), 4u);
  EXPECT_FALSE(light_buffer_shader(with({32, 32, 32, true, false}))) << "no ballots";
}

struct Size {
  uint32_t width, height, lights, triangles;
};

class LightBufferFrames : public testing::TestWithParam<Size> {};

TEST_P(LightBufferFrames, EqualBruteForce) {
  if (!offers_light_buffers()) GTEST_SKIP() << "no light buffers here";
  const auto [width, height, lights, triangles] = GetParam();
  const auto scene = triangle_soup(lights, triangles, lights);
  auto probe = SurfaceProbe::create(device_options("light_buffer"), scene);
  ASSERT_TRUE(probe) << probe.error().message;
  for (const CameraView& camera : {look_at({0.5f, 0.6f, 2.2f}, {0.5f, 0.5f, 0.5f}, 0.8f, width, height),
                                   look_at({0.5f, 0.5f, 0.5f}, {0.1f, 0.3f, 0.9f}, 1.4f, width, height)}) {
    const auto frame = probe->render(camera, width, height);
    ASSERT_TRUE(frame) << frame.error().message;
    const Count count = compare(*scene, camera, *frame);
    EXPECT_EQ(count.differing, 0u) << "of " << count.surfaces * lights;
    EXPECT_GT(count.surfaces, size_t{width} * height / 10);
    EXPECT_GT(count.lit, count.surfaces * lights / 100);
    EXPECT_GT(count.dark, count.surfaces * lights / 100);
  }
}

// Columns of tiles in even and odd numbers; lights below and above the 32 and 64 that wide subgroups trace at a time.
INSTANTIATE_TEST_SUITE_P(Sizes, LightBufferFrames,
                         testing::Values(Size{100, 60, 5, 700}, Size{128, 48, 7, 700}, Size{7, 70, 9, 700},
                                         Size{72, 40, 31, 300}, Size{65, 33, 70, 200}, Size{40, 24, 130, 150}),
                         [](const auto& test) {
                           return std::to_string(test.param.width) + "x" + std::to_string(test.param.height) + "_" +
                                  std::to_string(test.param.lights) + "_lights";
                         });

}  // namespace
}  // namespace gnomon::test
