// Device memory: a few large blocks for each memory type, divided by first fit; large pieces get a block of their own.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "common/result.h"
#include "gpu/vulkan/vulkan.h"

namespace gnomon::gpu {

enum class MemoryUse {
  device,    // device-local; mapped if the chosen memory is host-visible
  upload,    // written by the host, read by the device
  readback,  // written by the device, read by the host; cached
};

class MemoryBlock;

// A piece of a block. Plain data: its owner returns it with MemoryAllocator::free.
struct MemoryPiece {
  MemoryBlock* block = nullptr;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  uint64_t offset = 0;
  uint64_t bytes = 0;
  void* mapped = nullptr;  // host address of the first byte; nullptr if the memory is not mapped
};

// Any thread.
class MemoryAllocator {
 public:
  MemoryAllocator();
  ~MemoryAllocator();

  void open(VkPhysicalDevice physical, VkDevice device, bool unified);
  void close();

  // `linear`: true for buffers, false for images, which have blocks of their own. Error: out of memory.
  Result<MemoryPiece> allocate(const VkMemoryRequirements& need, MemoryUse use, bool linear);
  void free(const MemoryPiece& piece);

 private:
  Result<uint32_t> memory_type(uint32_t allowed, MemoryUse use) const;
  Result<MemoryBlock*> add_block(uint32_t type, bool linear, uint64_t bytes);

  VkDevice device_ = VK_NULL_HANDLE;
  VkPhysicalDeviceMemoryProperties properties_{};
  bool unified_ = false;
  std::mutex mutex_;
  std::vector<std::unique_ptr<MemoryBlock>> blocks_;
};

}  // namespace gnomon::gpu
