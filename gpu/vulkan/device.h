// A Vulkan device of ours: logical device, queues, memory, and the parking place of dropped objects.
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
  uint32_t queues = 1;  // for frames that overlap; fewer where the device has fewer
};

class Device;
// Whatever lives on a device keeps it alive.
using DevicePtr = std::shared_ptr<Device>;

class Device {
 public:
  static Result<DevicePtr> create(const DeviceOptions& options);
  ~Device();
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;

  VkDevice handle() const { return device_; }
  const PhysicalDevice& info() const { return info_; }
  const DeviceFeatures& features() const { return features_; }
  // Queues of one family: frames are spread over them. The first one also takes what is no frame.
  Queue& queue(size_t i = 0) { return *queues_[i]; }
  size_t queue_count() const { return queues_.size(); }
  MemoryAllocator& memory() { return memory_; }
  uint64_t validation_messages() const { return instance_->validation_messages(); }

  // Any thread. Parks what destroys an object until all work submitted so far has passed the queues' timelines.
  void retire(std::function<void()> destroy);
  // Any thread. Destroys what was parked and has passed; every frame slot calls it as it comes into use again.
  void collect();

 private:
  struct Parked {
    std::vector<uint64_t> values;  // of each queue
    std::function<void()> destroy;
  };

  Device() = default;
  Result<void> open(const DeviceOptions& options);

  std::unique_ptr<Instance> instance_;
  PhysicalDevice info_;
  DeviceFeatures features_;
  VkDevice device_ = VK_NULL_HANDLE;
  std::vector<std::unique_ptr<Queue>> queues_;
  MemoryAllocator memory_;
  std::mutex parking_;
  std::deque<Parked> parked_;  // values never decrease
};

// A Vulkan object that is parked when dropped: nobody else reasons about when the device is done with it.
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
