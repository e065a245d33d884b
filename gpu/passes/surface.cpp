// Writes the surface points from which the trace pass starts, by the same arithmetic.
#include "gpu/passes/passes.h"
#include "spirv/surface_comp.h"

namespace gnomon::gpu {
namespace {

class SurfacePass : public Pass {
 public:
  explicit SurfacePass(ComputeStep step) : step_(std::move(step)) {}

  std::string_view name() const override { return "surface"; }
  const PassLayout* layout() const override { return &step_.layout; }
  std::vector<Port> ports() const override {
    const auto bytes = [](const Capacity& c) { return uint64_t{c.width} * c.height * sizeof(SurfaceSample); };
    return {{resource::kTriangleId, Use::sampled}, {resource::kSurface, Use::storage_write, {{}, bytes}}};
  }
  void record(const FrameContext& frame) const override {
    const VkDeviceAddress samples = frame.ports[1].buffer->address();
    dispatch_tiles(frame, step_, std::as_bytes(std::span(&samples, 1)));
  }

 private:
  ComputeStep step_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_surface_pass(const DevicePtr& device) {
  return pass_of<SurfacePass>(make_compute_step(device, 1, surface_comp));
}

}  // namespace gnomon::gpu
