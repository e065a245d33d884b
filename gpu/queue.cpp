#include "gpu/queue.h"

namespace gnomon::gpu {

Result<void> Queue::open(VkDevice device, uint32_t family) {
  device_ = device;
  family_ = family;
  vkGetDeviceQueue(device, family, 0, &queue_);
  VkSemaphoreTypeCreateInfo type{};
  type.sType = VK_STRUCTURE_TYPE_SEMAPHORE_TYPE_CREATE_INFO;
  type.semaphoreType = VK_SEMAPHORE_TYPE_TIMELINE;
  VkSemaphoreCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO;
  create.pNext = &type;
  if (const VkResult r = vkCreateSemaphore(device, &create, nullptr, &timeline_); r != VK_SUCCESS)
    return vulkan_error(r, "creating a timeline semaphore");
  return {};
}

void Queue::close() {
  if (timeline_) vkDestroySemaphore(device_, timeline_, nullptr);
  timeline_ = VK_NULL_HANDLE;
}

Result<uint64_t> Queue::submit(VkCommandBuffer commands) {
  std::lock_guard lock(submitting_);
  const uint64_t value = submitted_ + 1;
  VkCommandBufferSubmitInfo buffer{};
  buffer.sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO;
  buffer.commandBuffer = commands;
  VkSemaphoreSubmitInfo signal{};
  signal.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO;
  signal.semaphore = timeline_;
  signal.value = value;
  signal.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  VkSubmitInfo2 submit{};
  submit.sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2;
  submit.commandBufferInfoCount = 1;
  submit.pCommandBufferInfos = &buffer;
  submit.signalSemaphoreInfoCount = 1;
  submit.pSignalSemaphoreInfos = &signal;
  if (const VkResult r = vkQueueSubmit2(queue_, 1, &submit, VK_NULL_HANDLE); r != VK_SUCCESS)
    return vulkan_error(r, "submitting work");
  submitted_ = value;
  return value;
}

Result<void> Queue::wait(uint64_t value) const {
  VkSemaphoreWaitInfo info{};
  info.sType = VK_STRUCTURE_TYPE_SEMAPHORE_WAIT_INFO;
  info.semaphoreCount = 1;
  info.pSemaphores = &timeline_;
  info.pValues = &value;
  const VkResult r = vkWaitSemaphores(device_, &info, UINT64_MAX);
  if (r != VK_SUCCESS) return vulkan_error(r, "waiting for the device");
  return {};
}

uint64_t Queue::completed() const {
  uint64_t value = 0;
  // A lost device completes nothing more: what waits for it is freed when the device is closed.
  if (vkGetSemaphoreCounterValue(device_, timeline_, &value) != VK_SUCCESS) return 0;
  return value;
}

}  // namespace gnomon::gpu
