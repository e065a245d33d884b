#include "client/view/ground_truth_renderer.h"

#include <future>

#include "gpu/wire/translate.h"

namespace gnomon::client {
namespace {

constexpr SceneId kScene{1};

}  // namespace

Result<std::unique_ptr<GroundTruthRenderer>> GroundTruthRenderer::create(const scenes::ScenePtr& scene,
                                                                         const ViewSize& size,
                                                                         const ClientRenderer::Options& own,
                                                                         const std::string& cache) {
  auto view = ClientRenderer::create(scene, size, own);
  if (!view) return view.error();
  std::unique_ptr<GroundTruthRenderer> ideal(new GroundTruthRenderer(std::move(*view), size));
  gpu::RendererOptions options;
  options.device = own.device;
  options.tracer_options.cache_folder = cache;
  auto renderer = gpu::make_renderer(options);
  if (!renderer) return renderer.error();
  ideal->renderer_ = std::move(*renderer);
  if (auto resident = ideal->renderer_->make_resident(kScene, scene); !resident) return resident.error();
  return ideal;
}

Result<AssembledFrame> GroundTruthRenderer::masks(const protocol::CameraView& camera, scenes::SceneTime time) {
  gpu::RenderJob job;
  job.id = JobId{++pictures_};
  job.scene = kScene;
  job.camera = gpu::from_wire(camera);
  job.width = size_.traced_width();
  job.height = size_.traced_height();
  job.time = time;
  std::promise<gpu::FrameDone> promise;
  auto submitted = renderer_->submit(job, [&](gpu::FrameDone done) { promise.set_value(std::move(done)); });
  if (!submitted) return submitted.error();
  const gpu::FrameDone done = promise.get_future().get();
  if (done.device_lost) return Error{"the device was lost"};
  AssembledFrame frame;
  frame.grid = done.mask.mask().grid;
  frame.planes = LightPlanes(std::vector<bool>(frame.grid.planes), 1);
  frame.words = unpacked(done.mask.mask());
  frame.arrived.assign(frame.words.size(), true);
  frame.moment.scene_time_us = static_cast<decltype(frame.moment.scene_time_us)>(time.count());
  return frame;
}

Result<Picture> GroundTruthRenderer::picture(const protocol::CameraView& camera, scenes::SceneTime time) {
  auto traced = masks(camera, time);
  if (!traced) return traced.error();
  auto seen = std::make_shared<ReceivedMasks>();
  seen->index = pictures_;
  seen->camera = camera;
  seen->mask = std::move(*traced);
  return view_.shade({.index = pictures_, .camera = camera, .seen = std::move(seen)});
}

}  // namespace gnomon::client
