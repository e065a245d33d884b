// Buffers and images: move-only owners that retire their objects when dropped (Device::retire).
#pragma once

#include <cstddef>
#include <span>

#include "gpu/vulkan/device.h"

namespace gnomon::gpu {

class Buffer {
 public:
  // Every buffer has a device address, and may be seen as texels where shaders load these; `usage` has the usages beside
  // that. Error: out of memory.
  static Result<Buffer> create(const DevicePtr& device, uint64_t bytes, VkBufferUsageFlags usage, MemoryUse use);

  Buffer() = default;
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Buffer();

  VkBuffer handle() const { return buffer_; }
  VkDeviceAddress address() const { return address_; }
  uint64_t bytes() const { return bytes_; }
  std::byte* mapped() const { return static_cast<std::byte*>(piece_.mapped); }

 private:
  void swap(Buffer& other);

  DevicePtr device_;
  VkBuffer buffer_ = VK_NULL_HANDLE;
  MemoryPiece piece_;
  VkDeviceAddress address_ = 0;
  uint64_t bytes_ = 0;
};

// A 2D image of one mip level with a view of it.
class Image {
 public:
  static Result<Image> create(const DevicePtr& device, VkExtent2D size, VkFormat format, VkImageUsageFlags usage);

  Image() = default;
  Image(Image&& other) noexcept { swap(other); }
  Image& operator=(Image&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Image();

  VkImage handle() const { return image_; }
  VkImageView view() const { return view_; }
  VkFormat format() const { return format_; }

 private:
  void swap(Image& other);

  DevicePtr device_;
  VkImage image_ = VK_NULL_HANDLE;
  VkImageView view_ = VK_NULL_HANDLE;
  VkFormat format_ = VK_FORMAT_UNDEFINED;
  MemoryPiece piece_;
};

VkImageAspectFlags aspect_of(VkFormat format);

// Records a full barrier: all later commands on the queue see everything that was written before.
void all_before_all_after(VkCommandBuffer commands);

// Records commands, submits them and waits for their end. It is used while loading, never for frames.
Result<void> run_now(const DevicePtr& device, const std::function<void(VkCommandBuffer)>& record);

// What an upload copies with one submit. 8 MiB take a third of a millisecond at 24 GB/s, less than a frame, so that
// frames that come meanwhile wait for one piece at most.
inline constexpr size_t kUploadPieceBytes = size_t{8} << 20;

// A device buffer with this content; blocking. After each piece it rests for as long as the piece took: an upload has at
// most half of the copies' time, whatever its size (scheduler/PROMISE.md). Where there is no content, the buffer has
// kNoElementBytes of zeros: shaders read the first element before they know whether there is one.
inline constexpr size_t kNoElementBytes = 64;  // of the largest element of any list
Result<Buffer> upload(const DevicePtr& device, std::span<const std::byte> content, VkBufferUsageFlags usage = 0);

}  // namespace gnomon::gpu
