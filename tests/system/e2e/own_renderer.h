// The masks of a camera without daemon and network, by the same renderer.
#pragma once

#include <gtest/gtest.h>

#include <future>

#include "client/view/client_renderer.h"
#include "gpu/vulkan_renderer.h"
#include "gpu/wire/translate.h"
#include "scenes/loader.h"

namespace gnomon::tests {

class OwnRenderer {
 public:
  explicit OwnRenderer(const std::filesystem::path& scene) {
    const auto opened = open(scene);
    EXPECT_TRUE(opened) << opened.error().message;
  }

  std::vector<uint64_t> render(const protocol::CameraView& camera, const client::ViewSize& size) {
    if (!renderer_) return {};
    auto words = std::make_shared<std::promise<std::vector<uint64_t>>>();
    gpu::RenderJob job;
    job.camera = gpu::from_wire(camera);
    job.width = size.traced_width();
    job.height = size.traced_height();
    const auto submitted =
        renderer_->submit(job, [words](gpu::FrameDone done) { words->set_value(unpacked(done.mask.mask())); });
    EXPECT_TRUE(submitted) << submitted.error().message;
    return submitted ? words->get_future().get() : std::vector<uint64_t>{};
  }

 private:
  Result<void> open(const std::filesystem::path& scene) {
    gpu::RendererOptions options;
    options.device = "cpu";
    auto made = gpu::make_renderer(options);
    if (!made) return made.error();
    renderer_ = std::move(*made);
    const auto loaded = scenes::load_scene(scene);
    if (!loaded) return loaded.error();
    return renderer_->make_resident(SceneId{0}, *loaded);
  }

  std::unique_ptr<gpu::Renderer> renderer_;
};

}  // namespace gnomon::tests
