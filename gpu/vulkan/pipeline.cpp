#include "gpu/vulkan/pipeline.h"

#include <array>

namespace gnomon::gpu {
namespace {

constexpr VkShaderStageFlags kStages =
    VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_FRAGMENT_BIT | VK_SHADER_STAGE_COMPUTE_BIT;

using ShaderModule = Owned<VkShaderModule, vkDestroyShaderModule>;

Result<ShaderModule> make_module(const DevicePtr& device, std::span<const uint32_t> words) {
  VkShaderModuleCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO;
  create.codeSize = words.size_bytes();
  create.pCode = words.data();
  VkShaderModule module = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateShaderModule(device->handle(), &create, nullptr, &module); r != VK_SUCCESS)
    return vulkan_error(r, "creating a shader module");
  return ShaderModule(device, module);
}

VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits which, const ShaderModule& module) {
  VkPipelineShaderStageCreateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
  info.stage = which;
  info.module = module.get();
  info.pName = "main";
  return info;
}

// One binding of each of these types, in their order.
Result<DescriptorSetLayout> make_set_layout(const DevicePtr& device, const std::vector<VkDescriptorType>& types) {
  std::vector<VkDescriptorSetLayoutBinding> bindings;
  for (const VkDescriptorType type : types)
    bindings.push_back({static_cast<uint32_t>(bindings.size()), type, 1, kStages, nullptr});
  VkDescriptorSetLayoutCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO;
  create.bindingCount = static_cast<uint32_t>(bindings.size());
  create.pBindings = bindings.data();
  VkDescriptorSetLayout handle = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateDescriptorSetLayout(device->handle(), &create, nullptr, &handle); r != VK_SUCCESS)
    return vulkan_error(r, "creating a descriptor set layout");
  return DescriptorSetLayout(device, handle);
}

// The state that all raster pipelines share.
struct RasterState {
  VkPipelineInputAssemblyStateCreateInfo assembly{};
  VkPipelineViewportStateCreateInfo viewport{};
  VkPipelineRasterizationStateCreateInfo raster{};
  VkPipelineMultisampleStateCreateInfo samples{};
  VkPipelineDepthStencilStateCreateInfo depth{};
  VkPipelineDynamicStateCreateInfo dynamic{};
  std::array<VkDynamicState, 3> dynamic_states{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR,
                                               VK_DYNAMIC_STATE_CULL_MODE};

  RasterState() {
    assembly.sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO;
    assembly.topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST;
    viewport.sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO;
    viewport.viewportCount = 1;
    viewport.scissorCount = 1;
    raster.sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO;
    raster.polygonMode = VK_POLYGON_MODE_FILL;
    raster.frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE;
    raster.lineWidth = 1.0f;
    samples.sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO;
    samples.rasterizationSamples = VK_SAMPLE_COUNT_1_BIT;
    depth.sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO;
    depth.depthTestEnable = VK_TRUE;
    depth.depthWriteEnable = VK_TRUE;
    depth.depthCompareOp = VK_COMPARE_OP_GREATER;
    dynamic.sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO;
    dynamic.dynamicStateCount = dynamic_states.size();
    dynamic.pDynamicStates = dynamic_states.data();
  }
  RasterState(const RasterState&) = delete;
  RasterState& operator=(const RasterState&) = delete;
};

}  // namespace

Result<PassLayout> make_pass_layout(const DevicePtr& device, uint32_t sampled_images, uint32_t storage_images,
                                    std::span<const uint32_t> texel_sets) {
  std::vector<VkDescriptorType> types{VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER};
  types.insert(types.end(), sampled_images, VK_DESCRIPTOR_TYPE_SAMPLED_IMAGE);
  types.insert(types.end(), storage_images, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE);
  auto set = make_set_layout(device, types);
  if (!set) return set.error();
  PassLayout layout;
  layout.set = std::move(*set);
  std::vector<DescriptorSetLayout> behind;
  std::vector<VkDescriptorSetLayout> sets{layout.set.get()};
  for (const uint32_t buffers : texel_sets) {
    auto texels = make_texel_set_layout(device, buffers);
    if (!texels) return texels.error();
    sets.push_back(texels->get());
    behind.push_back(std::move(*texels));
  }

  const VkPushConstantRange push{kStages, 0, kPushConstantBytes};
  VkPipelineLayoutCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO;
  create.setLayoutCount = static_cast<uint32_t>(sets.size());
  create.pSetLayouts = sets.data();
  create.pushConstantRangeCount = 1;
  create.pPushConstantRanges = &push;
  VkPipelineLayout handle = VK_NULL_HANDLE;
  if (const VkResult r = vkCreatePipelineLayout(device->handle(), &create, nullptr, &handle); r != VK_SUCCESS)
    return vulkan_error(r, "creating a pipeline layout");
  layout.pipeline = PipelineLayout(device, handle);
  return layout;
}

Result<DescriptorSetLayout> make_texel_set_layout(const DevicePtr& device, uint32_t buffers) {
  return make_set_layout(device, std::vector(buffers, VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER));
}

Result<Pipeline> make_compute_pipeline(const DevicePtr& device, const PassLayout& layout,
                                       std::span<const uint32_t> shader, uint32_t subgroup_size,
                                       std::span<const uint32_t> constants) {
  const auto module = make_module(device, shader);
  if (!module) return module.error();
  VkComputePipelineCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO;
  create.flags = VK_PIPELINE_CREATE_DISPATCH_BASE_BIT;  // for bands of a frame
  create.stage = stage(VK_SHADER_STAGE_COMPUTE_BIT, *module);
  std::vector<VkSpecializationMapEntry> entries;
  for (uint32_t id = 0; id < constants.size(); ++id) entries.push_back({id, id * 4, 4});
  const VkSpecializationInfo specialization{static_cast<uint32_t>(entries.size()), entries.data(),
                                            constants.size_bytes(), constants.data()};
  create.stage.pSpecializationInfo = &specialization;
  VkPipelineShaderStageRequiredSubgroupSizeCreateInfo size{};
  if (subgroup_size != 0 && device->features().subgroups.requests) {
    size.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_REQUIRED_SUBGROUP_SIZE_CREATE_INFO;
    size.requiredSubgroupSize = subgroup_size;
    create.stage.pNext = &size;
    create.stage.flags = VK_PIPELINE_SHADER_STAGE_CREATE_REQUIRE_FULL_SUBGROUPS_BIT;
  }
  create.layout = layout.pipeline.get();
  VkPipeline handle = VK_NULL_HANDLE;
  const VkResult r = vkCreateComputePipelines(device->handle(), VK_NULL_HANDLE, 1, &create, nullptr, &handle);
  if (r != VK_SUCCESS) return vulkan_error(r, "creating a compute pipeline");
  return Pipeline(device, handle);
}

Result<Pipeline> make_raster_pipeline(const DevicePtr& device, const PassLayout& layout,
                                      const RasterPipeline& what) {
  const auto vertex = make_module(device, what.vertex_shader);
  if (!vertex) return vertex.error();
  const auto fragment = make_module(device, what.fragment_shader);
  if (!fragment) return fragment.error();
  const std::array stages{stage(VK_SHADER_STAGE_VERTEX_BIT, *vertex),
                          stage(VK_SHADER_STAGE_FRAGMENT_BIT, *fragment)};

  VkPipelineVertexInputStateCreateInfo input{};
  input.sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO;

  std::vector<VkPipelineColorBlendAttachmentState> blends(what.colors.size());
  for (auto& blend : blends) blend.colorWriteMask = 0xf;
  VkPipelineColorBlendStateCreateInfo blend{};
  blend.sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO;
  blend.attachmentCount = static_cast<uint32_t>(blends.size());
  blend.pAttachments = blends.data();

  VkPipelineRenderingCreateInfo rendering{};
  rendering.sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO;
  rendering.colorAttachmentCount = static_cast<uint32_t>(what.colors.size());
  rendering.pColorAttachmentFormats = what.colors.data();
  rendering.depthAttachmentFormat = what.depth;

  const RasterState state;
  VkGraphicsPipelineCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO;
  create.pNext = &rendering;
  create.stageCount = stages.size();
  create.pStages = stages.data();
  create.pVertexInputState = &input;
  create.pInputAssemblyState = &state.assembly;
  create.pViewportState = &state.viewport;
  create.pRasterizationState = &state.raster;
  create.pMultisampleState = &state.samples;
  create.pDepthStencilState = &state.depth;
  create.pColorBlendState = &blend;
  create.pDynamicState = &state.dynamic;
  create.layout = layout.pipeline.get();
  VkPipeline handle = VK_NULL_HANDLE;
  const VkResult r = vkCreateGraphicsPipelines(device->handle(), VK_NULL_HANDLE, 1, &create, nullptr, &handle);
  if (r != VK_SUCCESS) return vulkan_error(r, "creating a raster pipeline");
  return Pipeline(device, handle);
}

}  // namespace gnomon::gpu
