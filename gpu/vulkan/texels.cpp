#include "gpu/vulkan/texels.h"

#include <string>

namespace gnomon::gpu {

Result<TexelSet> TexelSet::create(const DevicePtr& device, std::span<const TexelView> views) {
  TexelSet made;
  std::vector<VkBufferView> handles;
  for (const TexelView& view : views) {
    const uint64_t texels = view.buffer.bytes() / (view.format == VK_FORMAT_R32_UINT ? 4 : 16);
    const uint64_t most = device->features().max_texels;
    if (texels > most)
      return Error{"a buffer has " + std::to_string(texels) + " texels; the device shows " + std::to_string(most)};
    VkBufferViewCreateInfo create{};
    create.sType = VK_STRUCTURE_TYPE_BUFFER_VIEW_CREATE_INFO;
    create.buffer = view.buffer.handle();
    create.format = view.format;
    create.range = VK_WHOLE_SIZE;
    VkBufferView handle = VK_NULL_HANDLE;
    if (const VkResult r = vkCreateBufferView(device->handle(), &create, nullptr, &handle); r != VK_SUCCESS)
      return vulkan_error(r, "creating a view of a buffer");
    made.views_.emplace_back(device, handle);
    handles.push_back(handle);
  }

  const uint32_t count = static_cast<uint32_t>(handles.size());
  auto layout = make_texel_set_layout(device, count);
  if (!layout) return layout.error();
  made.layout_ = std::move(*layout);
  const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER, count};
  VkDescriptorPoolCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO;
  create.maxSets = 1;
  create.poolSizeCount = 1;
  create.pPoolSizes = &size;
  VkDescriptorPool pool = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateDescriptorPool(device->handle(), &create, nullptr, &pool); r != VK_SUCCESS)
    return vulkan_error(r, "creating a descriptor pool");
  made.pool_ = {device, pool};

  const VkDescriptorSetLayout set_layout = made.layout_.get();
  VkDescriptorSetAllocateInfo allocate{};
  allocate.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO;
  allocate.descriptorPool = pool;
  allocate.descriptorSetCount = 1;
  allocate.pSetLayouts = &set_layout;
  if (const VkResult r = vkAllocateDescriptorSets(device->handle(), &allocate, &made.set_); r != VK_SUCCESS)
    return vulkan_error(r, "allocating a descriptor set");
  std::vector<VkWriteDescriptorSet> writes;
  for (uint32_t i = 0; i < count; ++i) {
    VkWriteDescriptorSet write{};
    write.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET;
    write.dstSet = made.set_;
    write.dstBinding = i;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_TEXEL_BUFFER;
    write.pTexelBufferView = &handles[i];
    writes.push_back(write);
  }
  vkUpdateDescriptorSets(device->handle(), count, writes.data(), 0, nullptr);
  return made;
}

}  // namespace gnomon::gpu
