// The client's shading with given visibility bits (gpu/picture/reference_view.h), either of this view or of another
// view that was seen before.
#include <array>
#include <vector>

#include "gpu/passes/passes.h"
#include "gpu/passes/shading_uniforms.h"
#include "spirv/average_comp.h"
#include "spirv/shade_comp.h"
#include "spirv/shade_predicted_comp.h"

namespace gnomon::gpu {
namespace {

class ShadePass : public Pass {
 public:
  ShadePass(ComputeStep step, bool predicted) : step_(std::move(step)), predicted_(predicted) {}

  std::string_view name() const override { return predicted_ ? "shade_predicted" : "shade"; }
  const PassLayout* layout() const override { return &step_.layout; }
  std::vector<Port> ports() const override {
    const auto shading = [](const Capacity&) { return sizeof(ShadingUniforms); };
    const auto color = [](const Capacity& c) { return uint64_t{c.width} * c.height * sizeof(uint32_t); };
    std::vector<Port> ports{
        {resource::kTriangleId, Use::sampled},
        {resource::kGivenMasks, Use::storage_read, predicted_ ? given_buffer() : ResourceSpec{}},
        {resource::kShading, Use::storage_read, {{}, shading, MemoryUse::upload}},
        {resource::kColor, Use::storage_write, {{}, color}}};
    if (predicted_) {
      ports.push_back({resource::kSeenView, Use::storage_read});
      ports.push_back({resource::kSources, Use::storage_read});
      ports.push_back({resource::kShares, Use::storage_read, given_buffer()});
    }
    return ports;
  }
  void record(const FrameContext& frame) const override {
    std::vector<VkDeviceAddress> addresses;  // without the image
    for (const BoundPort& port : frame.ports.subspan(1)) addresses.push_back(port.buffer->address());
    dispatch_tiles(frame, step_, std::as_bytes(std::span(addresses)));
  }

 private:
  ComputeStep step_;
  bool predicted_;
};

// Averages what was shaded at 2x2 samples a pixel. The frame has the size of the samples, which is even.
class AveragePass : public Pass {
 public:
  explicit AveragePass(ComputeStep step) : step_(std::move(step)) {}

  std::string_view name() const override { return "average"; }
  const PassLayout* layout() const override { return &step_.layout; }
  std::vector<Port> ports() const override {
    const auto bytes = [](const Capacity& c) { return averaged_bytes(c.width, c.height); };
    return {{resource::kColor, Use::storage_read}, {resource::kAveraged, Use::storage_write, {{}, bytes}}};
  }
  void record(const FrameContext& frame) const override {
    const std::array addresses{frame.ports[0].buffer->address(), frame.ports[1].buffer->address()};
    dispatch_tiles(frame, step_, std::as_bytes(std::span(addresses)));
  }

 private:
  ComputeStep step_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_average_pass(const DevicePtr& device) {
  return pass_of<AveragePass>(make_compute_step(device, 1, average_comp));
}
Result<std::unique_ptr<Pass>> make_shade_pass(const DevicePtr& device) {
  return pass_of<ShadePass>(make_compute_step(device, 1, shade_comp), false);
}
Result<std::unique_ptr<Pass>> make_shade_predicted_pass(const DevicePtr& device) {
  return pass_of<ShadePass>(make_compute_step(device, 1, shade_predicted_comp), true);
}

}  // namespace gnomon::gpu
