// Pipelines and descriptor sets, reduced to the two shapes that the passes use.
#pragma once

#include <span>
#include <vector>

#include "gpu/vulkan/device.h"

namespace gnomon::gpu {

using DescriptorSetLayout = Owned<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout>;
using PipelineLayout = Owned<VkPipelineLayout, vkDestroyPipelineLayout>;
using Pipeline = Owned<VkPipeline, vkDestroyPipeline>;

// Every pass sees the same set: binding 0 the frame's uniforms, then the images that it samples, then those
// that compute writes, each in the order in which it declares them. All else goes through device addresses in push constants.
struct PassLayout {
  DescriptorSetLayout set;
  PipelineLayout pipeline;
};

// What every device offers, lavapipe of Mesa 22 included.
inline constexpr uint32_t kPushConstantBytes = 128;

Result<PassLayout> make_pass_layout(const DevicePtr& device, uint32_t sampled_images, uint32_t storage_images = 0);

Result<Pipeline> make_compute_pipeline(const DevicePtr& device, const PassLayout& layout,
                                       std::span<const uint32_t> shader);

struct RasterPipeline {
  std::span<const uint32_t> vertex_shader;
  std::span<const uint32_t> fragment_shader;
  std::vector<VkFormat> colors;
  VkFormat depth;
};

// No vertex streams; triangle lists, counter-clockwise front faces, reverse-Z depth test and write; dynamic viewport, scissor and cull
// mode.
Result<Pipeline> make_raster_pipeline(const DevicePtr& device, const PassLayout& layout,
                                      const RasterPipeline& what);

}  // namespace gnomon::gpu
