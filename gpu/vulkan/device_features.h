// What Gnomon asks of a Vulkan device, in one place: the baseline, and what it uses where offered.
#pragma once

#include <cstdint>
#include <string>

#include "gpu/vulkan/vulkan.h"

namespace gnomon::gpu {

struct DeviceFeatures {
  bool ray_query = false;
  bool atomic_int64 = false;    // 64-bit atomic operations on buffers
  bool unified_memory = false;  // device memory is host memory: nothing needs staging
  uint32_t subgroup_size = 0;
  uint32_t max_image_side = 0;  // pixels
  double timestamp_period_ns = 0;
};

// What the device lacks of the baseline, as words for a person; empty: usable.
std::string missing_features(VkPhysicalDevice device);

DeviceFeatures query_features(VkPhysicalDevice device);

// As sysfs names it; empty: the device is on no PCI bus or does not say where.
std::string pci_address(VkPhysicalDevice device);

// The feature chain that a VkDevice of ours is created with. Not copyable: the structs point at each other.
struct FeatureChain {
  explicit FeatureChain(const DeviceFeatures& offered);
  FeatureChain(const FeatureChain&) = delete;
  FeatureChain& operator=(const FeatureChain&) = delete;

  VkPhysicalDeviceFeatures2 features{};
  VkPhysicalDeviceVulkan12Features v12{};
  VkPhysicalDeviceVulkan13Features v13{};
  VkPhysicalDeviceAccelerationStructureFeaturesKHR acceleration{};
  VkPhysicalDeviceRayQueryFeaturesKHR ray_query{};
};

}  // namespace gnomon::gpu
