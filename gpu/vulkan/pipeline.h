// Pipelines and descriptor sets, reduced to the two shapes that the passes use.
#pragma once

#include <span>
#include <vector>

#include "gpu/vulkan/device.h"

namespace gnomon::gpu {

using DescriptorSetLayout = Owned<VkDescriptorSetLayout, vkDestroyDescriptorSetLayout>;
using PipelineLayout = Owned<VkPipelineLayout, vkDestroyPipelineLayout>;
using Pipeline = Owned<VkPipeline, vkDestroyPipeline>;

// Every pass has a set 0 of the same form: binding 0 has the frame's uniforms, then follow the images that the pass
// samples, then the storage images, each in the order in which the pass declares them. Everything else is accessed
// through device addresses in push constants, or as texels in the sets behind it (gpu/vulkan/texels.h).
struct PassLayout {
  DescriptorSetLayout set;
  PipelineLayout pipeline;
};

// The size that every device supports, including lavapipe of Mesa 22.
inline constexpr uint32_t kPushConstantBytes = 128;

// `texel_sets`: the number of buffers of each set behind set 0.
Result<PassLayout> make_pass_layout(const DevicePtr& device, uint32_t sampled_images, uint32_t storage_images = 0,
                                    std::span<const uint32_t> texel_sets = {});

// A set of that many storage texel buffers.
Result<DescriptorSetLayout> make_texel_set_layout(const DevicePtr& device, uint32_t buffers);

// `subgroup_size`: lanes of the shader's subgroups, all of which take part in every one; 0: the device may choose.
// `constants`: the shader's specialization constants 0, 1 and so on.
// Precondition: the size is among those that the device's features list.
Result<Pipeline> make_compute_pipeline(const DevicePtr& device, const PassLayout& layout,
                                       std::span<const uint32_t> shader, uint32_t subgroup_size = 0,
                                       std::span<const uint32_t> constants = {});

struct RasterPipeline {
  std::span<const uint32_t> vertex_shader;
  std::span<const uint32_t> fragment_shader;
  std::vector<VkFormat> colors;
  VkFormat depth;
};

// A pipeline without vertex streams, for triangle lists, counter-clockwise front faces, reverse-Z depth test and write;
// viewport, scissor and cull mode are dynamic.
Result<Pipeline> make_raster_pipeline(const DevicePtr& device, const PassLayout& layout,
                                      const RasterPipeline& what);

}  // namespace gnomon::gpu
