// The client's shading with given visibility bits (gpu/reference_view.h).
#include <array>

#include "gpu/passes/passes.h"
#include "gpu/shading_uniforms.h"
#include "spirv/shade_comp.h"

namespace gnomon::gpu {
namespace {

class ShadePass : public Pass {
 public:
  explicit ShadePass(ComputeStep step) : step_(std::move(step)) {}

  std::string_view name() const override { return "shade"; }
  const PassLayout* layout() const override { return &step_.layout; }
  std::vector<Port> ports() const override {
    const auto masks = [](const Capacity& c) { return c.grid().word_count() * sizeof(uint64_t); };
    const auto shading = [](const Capacity&) { return sizeof(ShadingUniforms); };
    const auto color = [](const Capacity& c) { return uint64_t{c.width} * c.height * sizeof(uint32_t); };
    return {{resource::kTriangleId, Use::sampled},
            {resource::kGivenMasks, Use::storage_read, {{}, masks, MemoryUse::upload}},
            {resource::kShading, Use::storage_read, {{}, shading, MemoryUse::upload}},
            {resource::kColor, Use::storage_write, {{}, color}}};
  }
  void record(const FrameContext& frame) const override {
    const std::array addresses{frame.ports[1].buffer->address(), frame.ports[2].buffer->address(),
                               frame.ports[3].buffer->address()};
    dispatch_tiles(frame, step_, std::as_bytes(std::span(addresses)));
  }

 private:
  ComputeStep step_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_shade_pass(const DevicePtr& device) {
  auto step = make_compute_step(device, 1, shade_comp);
  if (!step) return step.error();
  return std::unique_ptr<Pass>(std::make_unique<ShadePass>(std::move(*step)));
}

}  // namespace gnomon::gpu
