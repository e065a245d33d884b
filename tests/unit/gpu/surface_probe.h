// Exposes the inside of a frame to tests and benchmarks: the surface points from which the trace pass starts, and the
// masks that it makes of them.
#pragma once

#include <memory>
#include <vector>

#include "gpu/passes/passes.h"
#include "gpu/picture/blocking_frame.h"

namespace gnomon::gpu {

struct ProbedFrame {
  TileGrid grid;
  std::vector<SurfaceSample>
      samples;                       // row by row; their triangles by the numbers of scenes::build_world_mesh, then
                                     // those of build_moving_mesh
  std::vector<uint64_t> words;       // as common/tile_mask.h
  std::vector<uint64_t> valid_bits;  // of the same layout: which bits were traced
  FrameTiming timing;
  SampleCounts counts;

  const SurfaceSample& surface_at(uint32_t x, uint32_t y) const { return samples[size_t{y} * grid.width + x]; }
  TileMaskView mask() const { return {grid, words}; }
  TileMaskView care() const { return {grid, valid_bits}; }
};

// One thread. Blocking.
class SurfaceProbe {
 public:
  static Result<SurfaceProbe> create(const RendererOptions& options, const scenes::ScenePtr& scene);

  const Device& device() const { return frame_->device(); }
  const Tracer& tracer() const { return *frame_->tracer(); }
  const ResidentScene& scene() const { return frame_->scene(); }
  Result<ProbedFrame> render(const CameraView& camera, uint32_t width, uint32_t height, scenes::SceneTime time = {},
                             SampleCounts samples = {});

  // Lights where they are from now on; then, with `rebuild`, what the tracer builds for these.
  Result<void> set_lights(const std::vector<scenes::Light>& lights);
  Result<void> rebuild();
  // What the tracer builds for the extents of area lights, if it does.
  Result<void> build_areas();

 private:
  std::unique_ptr<BlockingFrame> frame_;
};

}  // namespace gnomon::gpu
