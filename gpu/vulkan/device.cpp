#include "gpu/vulkan/device.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

namespace gnomon::gpu {
namespace {

struct QueueFamily {
  uint32_t index = 0;
  uint32_t queues = 0;
  bool compute_only = false;
};

Result<QueueFamily> frame_queue_family(const PhysicalDevice& info, bool compute_only) {
  uint32_t count = 0;
  vkGetPhysicalDeviceQueueFamilyProperties(info.handle, &count, nullptr);
  std::vector<VkQueueFamilyProperties> families(count);
  vkGetPhysicalDeviceQueueFamilyProperties(info.handle, &count, families.data());
  constexpr VkQueueFlags both = VK_QUEUE_GRAPHICS_BIT | VK_QUEUE_COMPUTE_BIT;
  const auto find = [&](VkQueueFlags wanted) -> std::optional<QueueFamily> {
    for (uint32_t i = 0; i < count; ++i)
      if ((families[i].queueFlags & both) == wanted && families[i].timestampValidBits > 0)
        return QueueFamily{i, families[i].queueCount, wanted == VK_QUEUE_COMPUTE_BIT};
    return {};
  };
  auto family = compute_only ? find(VK_QUEUE_COMPUTE_BIT) : std::nullopt;
  if (!family) family = find(both);
  if (!family) return Error{"device '" + info.name + "' has no queue for graphics and compute with timestamps"};
  return *family;
}

}  // namespace

std::string_view to_string(VkResult result) {
  switch (result) {
    case VK_ERROR_OUT_OF_HOST_MEMORY: return "out of host memory";
    case VK_ERROR_OUT_OF_DEVICE_MEMORY: return "out of device memory";
    case VK_ERROR_INITIALIZATION_FAILED: return "initialisation failed";
    case VK_ERROR_DEVICE_LOST: return "device lost";
    case VK_ERROR_MEMORY_MAP_FAILED: return "memory could not be mapped";
    case VK_ERROR_LAYER_NOT_PRESENT: return "layer not present";
    case VK_ERROR_EXTENSION_NOT_PRESENT: return "extension not present";
    case VK_ERROR_FEATURE_NOT_PRESENT: return "feature not present";
    case VK_ERROR_INCOMPATIBLE_DRIVER: return "no Vulkan driver";
    case VK_ERROR_TOO_MANY_OBJECTS: return "too many objects";
    case VK_ERROR_FORMAT_NOT_SUPPORTED: return "format not supported";
    case VK_ERROR_FRAGMENTED_POOL: return "fragmented pool";
    case VK_ERROR_OUT_OF_POOL_MEMORY: return "out of pool memory";
    case VK_TIMEOUT: return "timed out";
    default: return "unknown Vulkan error";
  }
}

Error vulkan_error(VkResult result, std::string_view doing) {
  return {std::string(doing) + ": " + std::string(to_string(result)) + " (" + std::to_string(result) + ")"};
}

Result<DevicePtr> Device::create(const DeviceOptions& options, const DevicePtr& beside) {
  DevicePtr device(new Device);
  if (beside) device->instance_ = beside->instance_;
  if (auto opened = device->open(options); !opened) return opened.error();
  return device;
}

Result<void> Device::open(const DeviceOptions& options) {
  if (!instance_) {
    auto instance = Instance::create(options.validation);
    if (!instance) return instance.error();
    instance_ = std::move(*instance);
  }
  auto chosen = choose_device(*instance_, options.device);
  if (!chosen) return chosen.error();
  info_ = *chosen;
  features_ = query_features(info_.handle);
  if (!options.texel_loads) features_.max_texels = 0;
  const auto family = frame_queue_family(info_, options.compute_only);
  if (!family) return family.error();

  const uint32_t wanted = options.queues > 0 ? options.queues : family->compute_only ? 3 : 1;
  const uint32_t queue_count = std::clamp(wanted, 1u, family->queues);
  const std::vector<float> priorities(queue_count, 1.0f);
  VkDeviceQueueCreateInfo queue{};
  queue.sType = VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO;
  queue.queueFamilyIndex = family->index;
  queue.queueCount = queue_count;
  queue.pQueuePriorities = priorities.data();
  const FeatureChain chain(features_);
  constexpr std::array ray_query_extensions{VK_KHR_RAY_QUERY_EXTENSION_NAME,
                                            VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                            VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME};
  VkDeviceCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO;
  create.pNext = &chain.features;
  create.queueCreateInfoCount = 1;
  create.pQueueCreateInfos = &queue;
  if (features_.ray_query) {
    create.enabledExtensionCount = ray_query_extensions.size();
    create.ppEnabledExtensionNames = ray_query_extensions.data();
  }
  if (const VkResult r = vkCreateDevice(info_.handle, &create, nullptr, &device_); r != VK_SUCCESS)
    return vulkan_error(r, "opening device '" + info_.name + "'");
  memory_.open(info_.handle, device_, features_.unified_memory);
  for (uint32_t i = 0; i < queue_count; ++i) {
    queues_.push_back(std::make_unique<Queue>());
    if (auto open = queues_.back()->open(device_, family->index, i); !open) return open;
  }
  return {};
}

Device::~Device() {
  if (!device_) return;
  vkDeviceWaitIdle(device_);
  for (Parked& parked : parked_) parked.destroy();
  memory_.close();
  for (const auto& queue : queues_) queue->close();
  vkDestroyDevice(device_, nullptr);
}

void Device::retire(std::function<void()> destroy) {
  std::lock_guard lock(parking_);
  Parked parked{{}, std::move(destroy)};
  for (const auto& queue : queues_) parked.values.push_back(queue->submitted());
  parked_.push_back(std::move(parked));
}

void Device::collect() {
  std::vector<uint64_t> completed;
  for (const auto& queue : queues_) completed.push_back(queue->completed());
  const auto passed = [&](const Parked& parked) {
    return std::equal(parked.values.begin(), parked.values.end(), completed.begin(), std::less_equal<>());
  };
  std::lock_guard lock(parking_);
  while (!parked_.empty() && passed(parked_.front())) {
    parked_.front().destroy();
    parked_.pop_front();
  }
}

}  // namespace gnomon::gpu
