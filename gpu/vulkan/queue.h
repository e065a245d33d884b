// A device queue with a timeline semaphore: every submit gets the next value, which is reached when the device has
// passed it.
#pragma once

#include <atomic>
#include <cstdint>
#include <mutex>
#include <span>

#include "common/clock.h"
#include "common/result.h"
#include "gpu/vulkan/vulkan.h"

namespace gnomon::gpu {

// Any thread.
class Queue {
 public:
  Queue() = default;
  Queue(const Queue&) = delete;
  Queue& operator=(const Queue&) = delete;

  Result<void> open(VkDevice device, uint32_t family, uint32_t index);
  void close();

  uint32_t family() const { return family_; }

  // Starts `commands` one after the other, with one call of the driver, after the work that `other` has completed by
  // now, so that they see what it wrote. Returns the timeline value that marks the end of the first command buffer; the
  // others have the values that follow. Error: out of memory or device lost; then nothing was started.
  Result<uint64_t> submit(std::span<const VkCommandBuffer> commands, const Queue* other = nullptr);

  // Waits until the timeline has reached `value`. Error: device lost.
  Result<void> wait(uint64_t value) const;

  // Whether a submit failed for another reason than memory: the device is lost for good.
  bool lost() const { return lost_; }
  uint64_t submitted() const { return submitted_; }
  uint64_t completed() const;

 private:
  VkDevice device_ = VK_NULL_HANDLE;
  VkQueue queue_ = VK_NULL_HANDLE;
  VkSemaphore timeline_ = VK_NULL_HANDLE;
  uint32_t family_ = 0;
  std::mutex submitting_;
  std::atomic<uint64_t> submitted_ = 0;
  std::atomic<bool> lost_ = false;
};

}  // namespace gnomon::gpu
