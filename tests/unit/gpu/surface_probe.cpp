#include "tests/unit/gpu/surface_probe.h"

#include <cstring>

namespace gnomon::gpu {
namespace {

template <class T>
std::vector<T> copied(std::span<const std::byte> bytes, size_t count) {
  std::vector<T> out(count);
  if (count) std::memcpy(out.data(), bytes.data(), count * sizeof(T));
  return out;
}

}  // namespace

Result<SurfaceProbe> SurfaceProbe::create(const RendererOptions& options, const scenes::ScenePtr& scene) {
  auto frame = BlockingFrame::create(
      options, {"gbuffer", "trace", "surface", "readback_masks", "readback_valid_bits", "readback_surface"}, scene);
  if (!frame) return frame.error();
  SurfaceProbe probe;
  probe.frame_ = std::move(*frame);
  return probe;
}

Result<void> SurfaceProbe::set_lights(const std::vector<scenes::Light>& lights) {
  return frame_->scene().set_lights(lights);
}

Result<void> SurfaceProbe::rebuild() {
  if (!frame_->tracer()->builds_for_lights()) return {};
  ResidentScene& scene = frame_->scene();
  auto traced = build_for_lights(*frame_->tracer(), scene.scene(), scene.lights());
  if (!traced) return traced.error();
  scene.give_traced(std::move(*traced));
  return {};
}

Result<void> SurfaceProbe::build_areas() {
  if (!frame_->tracer()->soft_shader()) return {};
  ResidentScene& scene = frame_->scene();
  auto traced = build_for_areas(*frame_->tracer(), scene.scene(), scene.lights());
  if (!traced) return traced.error();
  scene.give_traced(std::move(*traced), Shadows::soft);
  return {};
}

Result<ProbedFrame> SurfaceProbe::render(const CameraView& camera, uint32_t width, uint32_t height,
                                         scenes::SceneTime time, SampleCounts samples) {
  const auto grid = frame_->reserve(width, height, time, samples);
  if (!grid) return grid.error();
  auto timing = frame_->render(camera, *grid);
  if (!timing) return timing.error();
  ProbedFrame probed;
  probed.grid = *grid;
  probed.samples = copied<SurfaceSample>(frame_->host(resource::kHostSurface), size_t{width} * height);
  const std::vector<uint32_t>& numbers = frame_->scene().clusters().numbers;
  for (SurfaceSample& sample : probed.samples)
    if (sample.triangle != 0 && sample.triangle <= numbers.size())
      sample.triangle = 1 + numbers[sample.triangle - 1];
  probed.words = copied<uint64_t>(frame_->host(resource::kHostMasks), grid->word_count());
  probed.valid_bits = copied<uint64_t>(frame_->host(resource::kHostValidBits), grid->word_count());
  probed.timing = std::move(*timing);
  probed.counts = frame_->scene().area_lights().samples(samples);
  return probed;
}

}  // namespace gnomon::gpu
