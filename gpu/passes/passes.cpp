#include "gpu/passes/passes.h"

namespace gnomon::gpu {

Result<std::unique_ptr<Pass>> make_pass(std::string_view name, const DevicePtr& device, const Tracer* tracer) {
  if (name == "gbuffer") return make_gbuffer_pass(device);
  if (name == "trace" && tracer) return make_trace_pass(device, *tracer);
  if (name == "trace") return Error{"pass 'trace' needs a tracer"};
  if (name == "shade") return make_shade_pass(device);
  if (name == "surface") return make_surface_pass(device);
  if (name == "readback") return make_readback_pass("readback", resource::kMasks, resource::kHostMasks);
  if (name == "readback_surface")
    return make_readback_pass("readback_surface", resource::kSurface, resource::kHostSurface);
  if (name == "readback_color") return make_readback_pass("readback_color", resource::kColor, resource::kHostColor);
  return Error{"no pass is called '" + std::string(name) +
               "'; there are gbuffer, trace, readback, surface, readback_surface, shade, "
               "readback_color"};
}

Result<ComputeStep> make_compute_step(const DevicePtr& device, uint32_t sampled_images,
                                      std::span<const uint32_t> shader) {
  auto layout = make_pass_layout(device, sampled_images);
  if (!layout) return layout.error();
  auto pipeline = make_compute_pipeline(device, *layout, shader);
  if (!pipeline) return pipeline.error();
  return ComputeStep{std::move(*layout), std::move(*pipeline)};
}

void dispatch_tiles(const FrameContext& frame, const ComputeStep& step, std::span<const std::byte> push) {
  const VkPipelineLayout layout = step.layout.pipeline.get();
  vkCmdBindPipeline(frame.commands, VK_PIPELINE_BIND_POINT_COMPUTE, step.pipeline.get());
  vkCmdBindDescriptorSets(frame.commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout, 0, 1, &frame.descriptors, 0,
                          nullptr);
  push_constants(frame.commands, layout, push);
  vkCmdDispatch(frame.commands, frame.grid.tiles_x(), frame.grid.tiles_y(), 1);
}

void push_constants(VkCommandBuffer commands, VkPipelineLayout layout, std::span<const std::byte> push) {
  constexpr VkShaderStageFlags stages =
      VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
  vkCmdPushConstants(commands, layout, stages, 0, static_cast<uint32_t>(push.size()), push.data());
}

}  // namespace gnomon::gpu
