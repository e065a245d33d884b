// A logical Vulkan device with its queues and memory, which defers the destruction of dropped objects.
#pragma once

#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "common/result.h"
#include "gpu/vulkan/device_features.h"
#include "gpu/vulkan/instance.h"
#include "gpu/vulkan/memory.h"
#include "gpu/vulkan/queue.h"

namespace gnomon::gpu {

struct DeviceOptions {
  std::string device;  // see choose_device
  ValidationOptions validation;
  // For frames that overlap; at most as the device has. 0: three on queues for compute alone, else one.
  uint32_t queues = 1;
  // On queues for compute alone, if the device has some; nothing may be drawn then. Work on several of these shares the
  // compute units, where that on several queues for graphics may take turns.
  bool compute_only = false;
  bool texel_loads = true;  // false: as if the device had no views of buffers that are large enough, for tests
};

class Device;
// Objects on a device keep it alive.
using DevicePtr = std::shared_ptr<Device>;

class Device {
 public:
  // `beside`: a device of the same physical one, whose instance it shares: a driver may load only so often in a process.
  static Result<DevicePtr> create(const DeviceOptions& options, const DevicePtr& beside = nullptr);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  VkDevice handle() const { return device_; }
  const PhysicalDevice& info() const { return info_; }
  const DeviceFeatures& features() const { return features_; }
  // Queues of one family, over which frames are spread. The first one is also used for all other work.
  Queue& queue(size_t i = 0) { return *queues_[i]; }
  size_t queue_count() const { return queues_.size(); }
  MemoryAllocator& memory() { return memory_; }
  uint64_t validation_messages() const { return instance_->validation_messages(); }

  // Any thread. Defers `destroy` until the device has passed all work that was submitted so far to any queue.
  void retire(std::function<void()> destroy);
  // Any thread. Calls the deferred functions whose work has passed. Every frame slot calls it before it is reused.
  void collect();
  // Held while a piece is uploaded and for the pause after it, so that all uploads together leave frames half of the time.
  std::mutex& uploading() { return uploading_; }

 private:
  struct Parked {
    std::vector<uint64_t> values;  // of each queue
    std::function<void()> destroy;
  };

  Device() = default;
  Result<void> open(const DeviceOptions& options);

  std::shared_ptr<Instance> instance_;
  PhysicalDevice info_;
  DeviceFeatures features_;
  VkDevice device_ = VK_NULL_HANDLE;
  std::vector<std::unique_ptr<Queue>> queues_;
  MemoryAllocator memory_;
  std::mutex uploading_;
  std::mutex parking_;
  std::deque<Parked> parked_;  // values never decrease
};

// Owns a Vulkan object, and retires it when dropped, so that its users need not track when the device has passed it.
template <class Handle, auto Destroy>
class Owned {
 public:
  Owned() = default;
  Owned(DevicePtr device, Handle handle) : device_(std::move(device)), handle_(handle) {}
  Owned(Owned&& other) noexcept
      : device_(std::move(other.device_)), handle_(std::exchange(other.handle_, nullptr)) {}
  Owned& operator=(Owned&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(handle_, other.handle_);
    return *this;
  }
  ~Owned() {
    if (!handle_) return;
    device_->retire([device = device_->handle(), handle = handle_] { Destroy(device, handle, nullptr); });
  }

  Handle get() const { return handle_; }
  explicit operator bool() const { return handle_ != nullptr; }

 private:
  DevicePtr device_;
  Handle handle_ = nullptr;
};

}  // namespace gnomon::gpu
