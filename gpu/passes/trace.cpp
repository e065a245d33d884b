// Traces every pair of pixel and light; writes the results as tile words, and which pairs were traced as words of the
// same layout.
#include <algorithm>
#include <array>
#include <cstring>

#include "gpu/passes/passes.h"
#include "gpu/tracers/tracer.h"

namespace gnomon::gpu {
namespace {

class TracePass : public Pass {
 public:
  TracePass(ComputeStep step, bool motion, bool by_texels)
      : step_(std::move(step)), motion_(motion), by_texels_(by_texels) {}

  std::string_view name() const override { return "trace"; }
  const PassLayout* layout() const override { return &step_.layout; }
  RunsIn runs_in() const override { return RunsIn::every_band; }
  bool for_resting_lights() const override { return motion_; }
  std::vector<Port> ports() const override {
    const auto bytes = [](const Capacity& c) { return c.grid().word_count() * sizeof(uint64_t); };
    return {{resource::kTriangleId, Use::sampled},
            {resource::kMasks, Use::storage_write, {{}, bytes}},
            {resource::kValidBits, Use::storage_write, {{}, bytes}}};
  }

  // Push constants: the addresses of the masks and the valid_bits, then those of the tracer.
  void record(const FrameContext& frame) const override {
    if (frame.samples.per_light > 1 && frame.scene.area_lights().set().count() == frame.scene.light_count()) return;
    std::array<std::byte, kPushConstantBytes> push{};
    const std::array words{frame.ports[1].buffer->address(), frame.ports[2].buffer->address()};
    const std::span<const std::byte> tracer = frame.posed.traced->push_constants();
    std::memcpy(push.data(), words.data(), sizeof(words));
    std::copy(tracer.begin(), tracer.end(), push.begin() + sizeof(words));
    const std::array texels{frame.scene.texels(), frame.posed.traced->texels()};
    dispatch_tiles(frame, step_, push, by_texels_ ? std::span(texels) : std::span<const VkDescriptorSet>());
  }

 private:
  ComputeStep step_;
  bool motion_, by_texels_;
};

}  // namespace

Result<std::unique_ptr<Pass>> make_trace_pass(const DevicePtr& device, const Tracer& tracer, bool motion) {
  const TraceShader shader = tracer.shader();
  const bool by_texels = shader.texel_buffers > 0;
  const std::array sets{1u, shader.texel_buffers};  // of the scene, and of what the tracer built
  auto step = make_compute_step(device, 1, shader.spirv, 0, shader.lanes, {},
                                by_texels ? std::span<const uint32_t>(sets) : std::span<const uint32_t>());
  if (step) step->tiles_at_once = shader.tiles;
  return pass_of<TracePass>(std::move(step), motion, by_texels);
}

}  // namespace gnomon::gpu
