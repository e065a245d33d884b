#include "gpu/vulkan/queue.h"

#include <vector>

namespace gnomon::gpu {

Result<void> Queue::open(VkDevice device, uint32_t family, uint32_t index) {
  device_ = device;
  family_ = family;
  vkGetDeviceQueue(device, family, index, &queue_);
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

Result<uint64_t> Queue::submit(std::span<const VkCommandBuffer> commands, const Queue* other) {
  VkSemaphoreSubmitInfo after{};
  if (other && other != this) {
    after.sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO;
    after.semaphore = other->timeline_;
    after.value = other->completed();
    after.stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
  }
  std::lock_guard lock(submitting_);
  const uint64_t first = submitted_ + 1;
  std::vector<VkCommandBufferSubmitInfo> buffers(commands.size());
  std::vector<VkSemaphoreSubmitInfo> signals(commands.size());
  std::vector<VkSubmitInfo2> submits(commands.size());
  for (size_t i = 0; i < commands.size(); ++i) {
    buffers[i].sType = VK_STRUCTURE_TYPE_COMMAND_BUFFER_SUBMIT_INFO;
    buffers[i].commandBuffer = commands[i];
    signals[i].sType = VK_STRUCTURE_TYPE_SEMAPHORE_SUBMIT_INFO;
    signals[i].semaphore = timeline_;
    signals[i].value = first + i;
    signals[i].stageMask = VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT;
    submits[i].sType = VK_STRUCTURE_TYPE_SUBMIT_INFO_2;
    submits[i].commandBufferInfoCount = 1;
    submits[i].pCommandBufferInfos = &buffers[i];
    submits[i].signalSemaphoreInfoCount = 1;
    submits[i].pSignalSemaphoreInfos = &signals[i];
  }
  if (after.semaphore && !submits.empty()) {
    submits.front().waitSemaphoreInfoCount = 1;
    submits.front().pWaitSemaphoreInfos = &after;
  }
  const VkResult r = vkQueueSubmit2(queue_, static_cast<uint32_t>(submits.size()), submits.data(), VK_NULL_HANDLE);
  if (r != VK_SUCCESS) {
    if (r != VK_ERROR_OUT_OF_HOST_MEMORY && r != VK_ERROR_OUT_OF_DEVICE_MEMORY) lost_ = true;
    return vulkan_error(r, "submitting work");
  }
  submitted_ = first + commands.size() - 1;
  return first;
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
  // A lost device completes nothing more; retired objects are destroyed when the device is closed.
  if (vkGetSemaphoreCounterValue(device_, timeline_, &value) != VK_SUCCESS) return 0;
  return value;
}

}  // namespace gnomon::gpu
