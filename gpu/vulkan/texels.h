// Buffers as texels: what shaders with BY_TEXELS (shaders/texels.glsl) load whole, 4 or 16 bytes at once.
#pragma once

#include <span>
#include <vector>

#include "gpu/vulkan/pipeline.h"
#include "gpu/vulkan/resources.h"

namespace gnomon::gpu {

// A whole buffer, by texels of one word (VK_FORMAT_R32_UINT) or of four (VK_FORMAT_R32G32B32A32_UINT).
struct TexelView {
  const Buffer& buffer;
  VkFormat format;
};

// An immutable descriptor set of storage texel buffers, in the order of its views. Passes bind it behind the set of the
// frame, so that frames of several scenes need no set of their own. The buffers outlive it.
class TexelSet {
 public:
  // Error: out of memory, or a buffer has more texels than the device's views show. Precondition: the device's features
  // have loads_texels().
  static Result<TexelSet> create(const DevicePtr& device, std::span<const TexelView> views);

  // VK_NULL_HANDLE if it was not created.
  VkDescriptorSet handle() const { return set_; }

 private:
  using View = Owned<VkBufferView, vkDestroyBufferView>;

  DescriptorSetLayout layout_;
  std::vector<View> views_;
  Owned<VkDescriptorPool, vkDestroyDescriptorPool> pool_;
  VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace gnomon::gpu
