#include "gpu/vulkan/resources.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <thread>
#include <utility>

#include "common/clock.h"

namespace gnomon::gpu {

Result<Buffer> Buffer::create(const DevicePtr& device, uint64_t bytes, VkBufferUsageFlags usage, MemoryUse use) {
  Buffer buffer;
  buffer.device_ = device;
  buffer.bytes_ = std::max<uint64_t>(bytes, 16);  // so that an empty list has an address too
  VkBufferCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO;
  create.size = buffer.bytes_;
  create.usage = usage | VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT | VK_BUFFER_USAGE_STORAGE_BUFFER_BIT;
  if (device->features().loads_texels()) create.usage |= VK_BUFFER_USAGE_STORAGE_TEXEL_BUFFER_BIT;
  if (const VkResult r = vkCreateBuffer(device->handle(), &create, nullptr, &buffer.buffer_); r != VK_SUCCESS)
    return vulkan_error(r, "creating a buffer");
  VkMemoryRequirements need{};
  vkGetBufferMemoryRequirements(device->handle(), buffer.buffer_, &need);
  const auto piece = device->memory().allocate(need, use, true);
  if (!piece) return piece.error();
  buffer.piece_ = *piece;
  if (const VkResult r = vkBindBufferMemory(device->handle(), buffer.buffer_, piece->memory, piece->offset);
      r != VK_SUCCESS)
    return vulkan_error(r, "binding a buffer");
  VkBufferDeviceAddressInfo address{};
  address.sType = VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO;
  address.buffer = buffer.buffer_;
  buffer.address_ = vkGetBufferDeviceAddress(device->handle(), &address);
  return buffer;
}

Buffer::~Buffer() {
  if (!buffer_) return;
  device_->retire([device = device_.get(), buffer = buffer_, piece = piece_] {
    vkDestroyBuffer(device->handle(), buffer, nullptr);
    if (piece.block) device->memory().free(piece);
  });
}

void Buffer::swap(Buffer& other) {
  std::swap(device_, other.device_);
  std::swap(buffer_, other.buffer_);
  std::swap(piece_, other.piece_);
  std::swap(address_, other.address_);
  std::swap(bytes_, other.bytes_);
}

VkImageAspectFlags aspect_of(VkFormat format) {
  return format == VK_FORMAT_D32_SFLOAT ? VK_IMAGE_ASPECT_DEPTH_BIT : VK_IMAGE_ASPECT_COLOR_BIT;
}

Result<Image> Image::create(const DevicePtr& device, VkExtent2D size, VkFormat format, VkImageUsageFlags usage) {
  Image image;
  image.device_ = device;
  image.format_ = format;
  VkImageCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO;
  create.imageType = VK_IMAGE_TYPE_2D;
  create.format = format;
  create.extent = {size.width, size.height, 1};
  create.mipLevels = 1;
  create.arrayLayers = 1;
  create.samples = VK_SAMPLE_COUNT_1_BIT;
  create.tiling = VK_IMAGE_TILING_OPTIMAL;
  create.usage = usage;
  if (const VkResult r = vkCreateImage(device->handle(), &create, nullptr, &image.image_); r != VK_SUCCESS)
    return vulkan_error(r, "creating an image");
  VkMemoryRequirements need{};
  vkGetImageMemoryRequirements(device->handle(), image.image_, &need);
  const auto piece = device->memory().allocate(need, MemoryUse::device, false);
  if (!piece) return piece.error();
  image.piece_ = *piece;
  if (const VkResult r = vkBindImageMemory(device->handle(), image.image_, piece->memory, piece->offset);
      r != VK_SUCCESS)
    return vulkan_error(r, "binding an image");
  VkImageViewCreateInfo view{};
  view.sType = VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO;
  view.image = image.image_;
  view.viewType = VK_IMAGE_VIEW_TYPE_2D;
  view.format = format;
  view.subresourceRange = {aspect_of(format), 0, 1, 0, 1};
  if (const VkResult r = vkCreateImageView(device->handle(), &view, nullptr, &image.view_); r != VK_SUCCESS)
    return vulkan_error(r, "creating an image view");
  return image;
}

Image::~Image() {
  if (!image_) return;
  device_->retire([device = device_.get(), image = image_, view = view_, piece = piece_] {
    if (view) vkDestroyImageView(device->handle(), view, nullptr);
    vkDestroyImage(device->handle(), image, nullptr);
    if (piece.block) device->memory().free(piece);
  });
}

void Image::swap(Image& other) {
  std::swap(device_, other.device_);
  std::swap(image_, other.image_);
  std::swap(view_, other.view_);
  std::swap(format_, other.format_);
  std::swap(piece_, other.piece_);
}

void all_before_all_after(VkCommandBuffer commands) {
  VkMemoryBarrier2 all{};
  all.sType = VK_STRUCTURE_TYPE_MEMORY_BARRIER_2;
  all.srcStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  all.srcAccessMask = VK_ACCESS_2_MEMORY_WRITE_BIT;
  all.dstStageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  all.dstAccessMask = VK_ACCESS_2_MEMORY_READ_BIT | VK_ACCESS_2_MEMORY_WRITE_BIT;
  VkDependencyInfo dependency{};
  dependency.sType = VK_STRUCTURE_TYPE_DEPENDENCY_INFO;
  dependency.memoryBarrierCount = 1;
  dependency.pMemoryBarriers = &all;
  vkCmdPipelineBarrier2(commands, &dependency);
}

Result<void> run_now(const DevicePtr& device, const std::function<void(VkCommandBuffer)>& record) {
  VkCommandPoolCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO;
  create.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
  create.queueFamilyIndex = device->queue().family();
  VkCommandPool handle = VK_NULL_HANDLE;
  if (const VkResult r = vkCreateCommandPool(device->handle(), &create, nullptr, &handle); r != VK_SUCCESS)
    return vulkan_error(r, "creating a command pool");
  const Owned<VkCommandPool, vkDestroyCommandPool> pool(device, handle);
  VkCommandBufferAllocateInfo allocate{};
  allocate.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO;
  allocate.commandPool = handle;
  allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
  allocate.commandBufferCount = 1;
  VkCommandBuffer commands = VK_NULL_HANDLE;
  if (const VkResult r = vkAllocateCommandBuffers(device->handle(), &allocate, &commands); r != VK_SUCCESS)
    return vulkan_error(r, "allocating a command buffer");
  VkCommandBufferBeginInfo begin{};
  begin.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO;
  begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
  vkBeginCommandBuffer(commands, &begin);
  record(commands);
  all_before_all_after(commands);
  if (const VkResult r = vkEndCommandBuffer(commands); r != VK_SUCCESS)
    return vulkan_error(r, "recording commands");
  const auto value = device->queue().submit({&commands, 1});
  if (!value) return value.error();
  return device->queue().wait(*value);
}

Result<Buffer> upload(const DevicePtr& device, std::span<const std::byte> content, VkBufferUsageFlags usage) {
  static constexpr std::array<std::byte, kNoElementBytes> kZeros{};
  if (content.empty()) content = kZeros;
  auto buffer = Buffer::create(device, content.size(), usage | VK_BUFFER_USAGE_TRANSFER_DST_BIT, MemoryUse::device);
  if (!buffer) return buffer;
  if (buffer->mapped()) {
    std::memcpy(buffer->mapped(), content.data(), content.size());
    return buffer;
  }
  const auto staging = Buffer::create(device, std::min(content.size(), kUploadPieceBytes),
                                      VK_BUFFER_USAGE_TRANSFER_SRC_BIT, MemoryUse::upload);
  if (!staging) return staging.error();
  for (size_t at = 0; at < content.size(); at += kUploadPieceBytes) {
    const size_t bytes = std::min(kUploadPieceBytes, content.size() - at);
    std::memcpy(staging->mapped(), content.data() + at, bytes);
    const std::lock_guard one_at_a_time(device->uploading());
    const TimePoint began = Clock::now();
    const VkBufferCopy region{0, at, bytes};
    const auto copied = run_now(device, [&](VkCommandBuffer commands) {
      vkCmdCopyBuffer(commands, staging->handle(), buffer->handle(), 1, &region);
    });
    if (!copied) return copied.error();
    if (at + bytes < content.size()) std::this_thread::sleep_for(Clock::now() - began);
  }
  return buffer;
}

}  // namespace gnomon::gpu
