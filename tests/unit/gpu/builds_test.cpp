// Whoever a renderer is told to have its structures built by builds them: for the daemon that is a confined process, as
// their time and memory depend on what a stranger's file says.
#include <gtest/gtest.h>

#include <atomic>

#include "tests/unit/gpu/made_scenes.h"
#include "tests/unit/gpu/test_device.h"

namespace gnomon::test {
namespace {

class CountedBuilds : public gpu::StructureBuilds {
 public:
  Result<gpu::Bvh> bvh(const scenes::WorldMesh& mesh) const override {
    ++count;
    return here_->bvh(mesh);
  }
  Result<gpu::light_buffer::LightBuffer> light_buffer(
      const scenes::WorldMesh& mesh, const scenes::Bounds& bounds, std::span<const gpu::exact::TracedLight> lights,
      const gpu::light_buffer::BuildSettings& settings) const override {
    ++count;
    return here_->light_buffer(mesh, bounds, lights, settings);
  }

  mutable std::atomic<int> count = 0;

 private:
  gpu::StructureBuildsPtr here_ = gpu::builds_here();
};

TEST(Builds, EveryTracerOfTheHostHasThemDoneByWhomItIsTold) {
  for (const std::string& tracer : tracers()) {
    if (tracer == "ray_query") continue;  // its structures are the device's own
    const auto builds = std::make_shared<CountedBuilds>();
    gpu::RendererOptions options = device_options(tracer);
    options.tracer_options.builds = builds;
    const auto renderer = gpu::make_renderer(options);
    ASSERT_TRUE(renderer) << renderer.error().message;
    ASSERT_TRUE((*renderer)->make_resident(SceneId{1}, triangle_soup(1, 40, 2)));
    EXPECT_GT(builds->count, 0) << tracer;
  }
}

}  // namespace
}  // namespace gnomon::test
