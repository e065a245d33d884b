// All kinds of work under VK_LAYER_KHRONOS_validation, with synchronization checks, give no messages.
#include <gtest/gtest.h>

#include <algorithm>
#include <future>
#include <mutex>
#include <string_view>

#include "gpu/picture/reference_view.h"
#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

using namespace gpu;

// The number of messages so far; the layer reports them on any thread.
class Heard {
 public:
  RendererOptions options(const std::string& tracer) {
    RendererOptions out = device_options(tracer);
    out.validation.enabled = true;
    out.validation.on_message = [this](std::string_view message) {
      std::lock_guard lock(mutex_);
      all_ += std::string(message) + "\n";
    };
    return out;
  }
  std::string all() const {
    std::lock_guard lock(mutex_);
    return all_;
  }

 private:
  mutable std::mutex mutex_;
  std::string all_;
};

void render_some(Renderer& renderer, SceneId scene, uint32_t width, uint32_t height) {
  std::vector<std::future<void>> arrivals;
  for (uint64_t i = 0; i < 6; ++i) {
    while (renderer.free_slots() == 0) {
      arrivals.front().wait();
      arrivals.erase(arrivals.begin());
    }
    auto arrived = std::make_shared<std::promise<void>>();
    arrivals.push_back(arrived->get_future());
    const CameraView camera = look_at({0.5f, 0.6f, 2.2f}, {0.5f, 0.5f, 0.5f}, 0.8f, width, height);
    RenderJob job{JobId(i), scene, camera, width, height, std::chrono::milliseconds(250 * i)};
    if (i % 2) job.tile_rows = i % 4 == 1 ? 2 : 0;
    if (i == 4) job.untraced = LightSet(0b10);
    const auto on_done = [arrived](FrameDone done) {
      if (!done.complete) return;
      done.mask.drop();
      arrived->set_value();
    };
    const auto submitted = renderer.submit(job, on_done);
    ASSERT_TRUE(submitted) << submitted.error().message;
    if (job.tile_rows) {
      ASSERT_TRUE(renderer.resume(job.id, height, on_done));
    }
  }
  for (auto& a : arrivals) a.wait();
}

// The tests are skipped if the layer is not installed.
bool layer_is_there() {
  uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.end(), [](const VkLayerProperties& layer) {
    return std::string_view(layer.layerName) == "VK_LAYER_KHRONOS_validation";
  });
}

class Validation : public testing::Test {
 protected:
  void SetUp() override {
    if (!layer_is_there()) GTEST_SKIP() << "the validation layer is not installed here";
  }
};

TEST_F(Validation, TheLayerListens) {
  Heard heard;
  auto device = Device::create({device_options().device, heard.options("bvh").validation});
  ASSERT_TRUE(device) << device.error().message;
  // Wrong on purpose, and harmless: a buffer of no bytes.
  VkBufferCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  create.usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT;
  VkBuffer buffer = VK_NULL_HANDLE;
  if (vkCreateBuffer((*device)->handle(), &create, nullptr, &buffer) == VK_SUCCESS)
    vkDestroyBuffer((*device)->handle(), buffer, nullptr);
  EXPECT_GT((*device)->validation_messages(), 0u);
  EXPECT_NE(heard.all().find("VUID-VkBufferCreateInfo-size"), std::string::npos) << heard.all();
}

TEST_F(Validation, FramesOfEveryTracerAreClean) {
  for (const std::string& tracer : tracers()) {
    SCOPED_TRACE(tracer);
    Heard heard;
    {
      auto renderer = make_renderer(heard.options(tracer));
      ASSERT_TRUE(renderer) << renderer.error().message;
      ASSERT_TRUE((*renderer)->make_resident(SceneId(1), triangle_soup(2, 200, 5)));
      ASSERT_TRUE((*renderer)->make_resident(
          SceneId(2), checks_over_floor(point_light({0.3f, 3.0f, 0.2f}), 8, scenes::AlphaMode::mask)));
      ASSERT_TRUE((*renderer)->make_resident(SceneId(3), triangle_soup(2, 0, 0)));
      ASSERT_TRUE((*renderer)->make_resident(SceneId(4), swinging_soup(3, {.body = true, .light = true})));
      for (const uint32_t scene : {1u, 2u, 3u, 4u}) render_some(**renderer, SceneId(scene), 100, 60);
      render_some(**renderer, SceneId(1), 333, 200);
      (*renderer)->evict(SceneId(1));
      render_some(**renderer, SceneId(2), 64, 64);
    }
    EXPECT_EQ(heard.all(), "");
  }
}

TEST_F(Validation, ReferenceViewAndProbeAreClean) {
  Heard heard;
  {
    const auto scene = checks_over_floor(point_light({0.3f, 3.0f, 0.2f}), 8, scenes::AlphaMode::mask);
    auto probe = SurfaceProbe::create(heard.options("bvh"), scene);
    ASSERT_TRUE(probe) << probe.error().message;
    const CameraView camera = look_at({3, 2, 4}, {0, 0, 0}, 0.9f, 120, 70);
    const auto frame = probe->render(camera, 120, 70);
    ASSERT_TRUE(frame) << frame.error().message;
    auto view = ReferenceView::create(heard.options("bvh"), scene);
    ASSERT_TRUE(view) << view.error().message;
    ASSERT_TRUE((*view)->suggest_exposure(camera));
    ASSERT_TRUE((*view)->render(camera, 120, 70, frame->mask()));
    // What is seen stays on the device, and the next frames begin before it has passed.
    Reprojection* reprojection = (*view)->reprojection().value();
    for (const float x : {3.1f, 3.2f, 3.3f}) {
      const auto seen = reprojection->see(camera, frame->mask(), {});
      ASSERT_TRUE(seen) << seen.error().message;
      const CameraView later = look_at({x, 2, 4}, {0, 0, 0}, 0.9f, 120, 70);
      ASSERT_TRUE((*view)->predict(later, 120, 70, *seen));
      const auto raster = reprojection->rasterise(later, 120, 70, {});
      ASSERT_TRUE(raster) << raster.error().message;
      ASSERT_TRUE(reprojection->sources(*raster, seen->raster));
    }
  }
  EXPECT_EQ(heard.all(), "");
}

}  // namespace
}  // namespace gnomon::test
