#include "gpu/vulkan/memory.h"

#include <algorithm>
#include <optional>

namespace gnomon::gpu {
namespace {

constexpr uint64_t kBlockBytes = uint64_t{32} << 20;
constexpr uint64_t kLargePieceBytes = kBlockBytes / 4;

uint64_t align_up(uint64_t value, uint64_t alignment) { return (value + alignment - 1) / alignment * alignment; }

}  // namespace

class MemoryBlock {
 public:
  MemoryBlock(VkDeviceMemory memory, void* mapped, uint32_t type, bool linear, uint64_t bytes)
      : memory_(memory), mapped_(static_cast<std::byte*>(mapped)), type_(type), linear_(linear), bytes_(bytes) {
    gaps_[0] = bytes;
  }

  bool serves(uint32_t type, bool linear) const { return type_ == type && linear_ == linear; }
  bool unused() const { return gaps_.size() == 1 && gaps_.begin()->second == bytes_; }
  VkDeviceMemory memory() const { return memory_; }

  std::optional<MemoryPiece> cut(uint64_t bytes, uint64_t alignment) {
    for (auto gap = gaps_.begin(); gap != gaps_.end(); ++gap) {
      const uint64_t begin = gap->first, end = begin + gap->second;
      const uint64_t at = align_up(begin, alignment);
      if (at + bytes > end) continue;
      gaps_.erase(gap);
      if (at > begin) gaps_[begin] = at - begin;
      if (end > at + bytes) gaps_[at + bytes] = end - (at + bytes);
      return MemoryPiece{this, memory_, at, bytes, mapped_ ? mapped_ + at : nullptr};
    }
    return std::nullopt;
  }

  void give_back(uint64_t offset, uint64_t bytes) {
    auto gap = gaps_.emplace(offset, bytes).first;
    if (const auto next = std::next(gap); next != gaps_.end() && offset + bytes == next->first) {
      gap->second += next->second;
      gaps_.erase(next);
    }
    if (gap == gaps_.begin()) return;
    if (const auto previous = std::prev(gap); previous->first + previous->second == offset) {
      previous->second += gap->second;
      gaps_.erase(gap);
    }
  }

 private:
  VkDeviceMemory memory_;
  std::byte* mapped_;
  uint32_t type_;
  bool linear_;
  uint64_t bytes_;
  std::map<uint64_t, uint64_t> gaps_;  // offset -> bytes, never adjacent
};

MemoryAllocator::MemoryAllocator() = default;
MemoryAllocator::~MemoryAllocator() = default;

void MemoryAllocator::open(VkPhysicalDevice physical, VkDevice device, bool unified) {
  device_ = device;
  unified_ = unified;
  vkGetPhysicalDeviceMemoryProperties(physical, &properties_);
}

void MemoryAllocator::close() {
  for (const auto& block : blocks_) vkFreeMemory(device_, block->memory(), nullptr);
  blocks_.clear();
}

Result<uint32_t> MemoryAllocator::memory_type(uint32_t allowed, MemoryUse use) const {
  constexpr VkMemoryPropertyFlags local = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT;
  constexpr VkMemoryPropertyFlags host = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
  constexpr VkMemoryPropertyFlags cached = host | VK_MEMORY_PROPERTY_HOST_CACHED_BIT;
  std::vector<VkMemoryPropertyFlags> wishes;  // in order of preference
  switch (use) {
    case MemoryUse::device:
      if (unified_) wishes.push_back(local | host);
      wishes.insert(wishes.end(), {local, 0});
      break;
    case MemoryUse::upload: wishes = {host}; break;
    case MemoryUse::readback: wishes = {cached, host}; break;
  }
  for (const VkMemoryPropertyFlags wish : wishes)
    for (uint32_t i = 0; i < properties_.memoryTypeCount; ++i)
      if ((allowed >> i & 1) && (properties_.memoryTypes[i].propertyFlags & wish) == wish) return i;
  return Error{"the device has no memory of the kind that is needed"};
}

Result<MemoryBlock*> MemoryAllocator::add_block(uint32_t type, bool linear, uint64_t bytes) {
  VkMemoryAllocateFlagsInfo flags{};
  flags.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO;
  flags.flags = VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT;
  VkMemoryAllocateInfo info{};
  info.sType = VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO;
  info.pNext = linear ? &flags : nullptr;
  info.allocationSize = bytes;
  info.memoryTypeIndex = type;
  VkDeviceMemory memory = VK_NULL_HANDLE;
  if (const VkResult r = vkAllocateMemory(device_, &info, nullptr, &memory); r != VK_SUCCESS)
    return vulkan_error(r, "allocating " + std::to_string(bytes >> 20) + " MiB of device memory");
  void* mapped = nullptr;
  if (properties_.memoryTypes[type].propertyFlags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT) {
    if (const VkResult r = vkMapMemory(device_, memory, 0, VK_WHOLE_SIZE, 0, &mapped); r != VK_SUCCESS) {
      vkFreeMemory(device_, memory, nullptr);
      return vulkan_error(r, "mapping device memory");
    }
  }
  blocks_.push_back(std::make_unique<MemoryBlock>(memory, mapped, type, linear, bytes));
  return blocks_.back().get();
}

Result<MemoryPiece> MemoryAllocator::allocate(const VkMemoryRequirements& need, MemoryUse use, bool linear) {
  std::lock_guard lock(mutex_);
  const auto type = memory_type(need.memoryTypeBits, use);
  if (!type) return type.error();
  const bool large = need.size >= kLargePieceBytes;
  std::optional<MemoryPiece> piece;
  if (!large)
    for (const auto& block : blocks_)
      if (block->serves(*type, linear) && (piece = block->cut(need.size, need.alignment))) break;
  if (!piece) {
    auto block = add_block(*type, linear, large ? need.size : kBlockBytes);
    if (!block) return block.error();
    piece = (*block)->cut(need.size, need.alignment);
  }
  return *piece;
}

void MemoryAllocator::free(const MemoryPiece& piece) {
  std::lock_guard lock(mutex_);
  piece.block->give_back(piece.offset, piece.bytes);
  if (!piece.block->unused()) return;
  vkFreeMemory(device_, piece.memory, nullptr);
  std::erase_if(blocks_, [&](const auto& block) { return block.get() == piece.block; });
}

}  // namespace gnomon::gpu
