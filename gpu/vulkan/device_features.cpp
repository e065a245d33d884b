#include "gpu/vulkan/device_features.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <string_view>
#include <vector>

namespace gnomon::gpu {
namespace {

bool offers(VkPhysicalDevice device, std::string_view extension) {
  uint32_t count = 0;
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, nullptr);
  std::vector<VkExtensionProperties> all(count);
  vkEnumerateDeviceExtensionProperties(device, nullptr, &count, all.data());
  return std::any_of(all.begin(), all.end(), [&](const auto& e) { return extension == e.extensionName; });
}

bool offers_ray_query(VkPhysicalDevice device) {
  if (!offers(device, VK_KHR_RAY_QUERY_EXTENSION_NAME) ||
      !offers(device, VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME) ||
      !offers(device, VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME))
    return false;
  VkPhysicalDeviceRayQueryFeaturesKHR ray_query{};
  ray_query.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR;
  VkPhysicalDeviceAccelerationStructureFeaturesKHR acceleration{};
  acceleration.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR;
  acceleration.pNext = &ray_query;
  VkPhysicalDeviceFeatures2 features{};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &acceleration;
  vkGetPhysicalDeviceFeatures2(device, &features);
  return ray_query.rayQuery && acceleration.accelerationStructure;
}

void query_int64(VkPhysicalDevice device, DeviceFeatures& offered) {
  VkPhysicalDeviceVulkan12Features v12{};
  v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  VkPhysicalDeviceFeatures2 features{};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &v12;
  vkGetPhysicalDeviceFeatures2(device, &features);
  offered.int64 = features.features.shaderInt64;
  offered.atomic_int64 = offered.int64 && v12.shaderBufferInt64Atomics;
}

bool offers_subgroup_size_control(VkPhysicalDevice device) {
  VkPhysicalDeviceVulkan13Features v13{};
  v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
  VkPhysicalDeviceFeatures2 features{};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &v13;
  vkGetPhysicalDeviceFeatures2(device, &features);
  return v13.subgroupSizeControl && v13.computeFullSubgroups;
}

SubgroupFeatures subgroups_of(VkPhysicalDevice device) {
  VkPhysicalDeviceVulkan13Properties sizes{};
  sizes.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_PROPERTIES;
  VkPhysicalDeviceSubgroupProperties usual{};
  usual.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
  usual.pNext = &sizes;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &usual;
  vkGetPhysicalDeviceProperties2(device, &properties);
  SubgroupFeatures offered;
  offered.requests =
      offers_subgroup_size_control(device) && (sizes.requiredSubgroupSizeStages & VK_SHADER_STAGE_COMPUTE_BIT);
  offered.usual = usual.subgroupSize;
  offered.least = offered.requests ? sizes.minSubgroupSize : offered.usual;
  offered.most = offered.requests ? sizes.maxSubgroupSize : offered.usual;
  constexpr VkSubgroupFeatureFlags needed = VK_SUBGROUP_FEATURE_BALLOT_BIT | VK_SUBGROUP_FEATURE_VOTE_BIT;
  offered.ballots_and_votes = (usual.supportedOperations & needed) == needed;
  return offered;
}

}  // namespace

std::string missing_features(VkPhysicalDevice device) {
  VkPhysicalDeviceProperties properties{};
  vkGetPhysicalDeviceProperties(device, &properties);
  if (properties.apiVersion < VK_API_VERSION_1_3) return "Vulkan 1.3";

  VkPhysicalDeviceSubgroupProperties subgroup{};
  subgroup.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SUBGROUP_PROPERTIES;
  VkPhysicalDeviceProperties2 properties2{};
  properties2.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties2.pNext = &subgroup;
  vkGetPhysicalDeviceProperties2(device, &properties2);

  VkPhysicalDeviceVulkan13Features v13{};
  v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
  VkPhysicalDeviceVulkan12Features v12{};
  v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  v12.pNext = &v13;
  VkPhysicalDeviceFeatures2 features{};
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &v12;
  vkGetPhysicalDeviceFeatures2(device, &features);

  std::string missing;
  const auto need = [&missing](VkBool32 offered, std::string_view name) {
    if (offered) return;
    if (!missing.empty()) missing += ", ";
    missing += name;
  };
  need(features.features.multiDrawIndirect, "multiDrawIndirect");
  need(v12.bufferDeviceAddress, "bufferDeviceAddress");
  need(v12.timelineSemaphore, "timelineSemaphore");
  need(v12.scalarBlockLayout, "scalarBlockLayout");
  need(v13.maintenance4, "maintenance4");
  need(v13.dynamicRendering, "dynamicRendering");
  need(v13.synchronization2, "synchronization2");
  need((subgroup.supportedStages & VK_SHADER_STAGE_COMPUTE_BIT) &&
           (subgroup.supportedOperations & VK_SUBGROUP_FEATURE_ARITHMETIC_BIT),
       "subgroup arithmetic");
  return missing;
}

std::string pci_address(VkPhysicalDevice device) {
  if (!offers(device, VK_EXT_PCI_BUS_INFO_EXTENSION_NAME)) return {};
  VkPhysicalDevicePCIBusInfoPropertiesEXT bus{};
  bus.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PCI_BUS_INFO_PROPERTIES_EXT;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &bus;
  vkGetPhysicalDeviceProperties2(device, &properties);
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%04x:%02x:%02x.%x", bus.pciDomain, bus.pciBus, bus.pciDevice,
                bus.pciFunction);
  return text.data();
}

DeviceFeatures query_features(VkPhysicalDevice device) {
  VkPhysicalDeviceProperties properties{};
  vkGetPhysicalDeviceProperties(device, &properties);
  DeviceFeatures offered;
  offered.ray_query = offers_ray_query(device);
  query_int64(device, offered);
  const VkPhysicalDeviceType type = properties.deviceType;
  offered.unified_memory = type == VK_PHYSICAL_DEVICE_TYPE_CPU || type == VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU;
  offered.subgroups = subgroups_of(device);
  const VkPhysicalDeviceLimits& limits = properties.limits;
  offered.max_image_side =
      std::min({limits.maxImageDimension2D, limits.maxFramebufferWidth, limits.maxFramebufferHeight});
  offered.max_texels = limits.maxTexelBufferElements;
  offered.max_sets = limits.maxBoundDescriptorSets;
  offered.timestamp_period_ns = limits.timestampPeriod;
  return offered;
}

FeatureChain::FeatureChain(const DeviceFeatures& offered) {
  features.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2;
  features.pNext = &v12;
  features.features.multiDrawIndirect = VK_TRUE;
  features.features.shaderInt64 = offered.int64;
  v12.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES;
  v12.pNext = &v13;
  v12.bufferDeviceAddress = VK_TRUE;
  v12.shaderBufferInt64Atomics = offered.atomic_int64;
  v12.timelineSemaphore = VK_TRUE;
  v12.scalarBlockLayout = VK_TRUE;
  v13.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_3_FEATURES;
  v13.computeFullSubgroups = offered.subgroups.requests;
  v13.dynamicRendering = VK_TRUE;
  v13.maintenance4 = VK_TRUE;  // for LocalSizeId of SPIR-V 1.6, and for fragment shaders that ignore varyings
  v13.subgroupSizeControl = offered.subgroups.requests;
  v13.synchronization2 = VK_TRUE;
  acceleration.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR;
  acceleration.accelerationStructure = VK_TRUE;
  acceleration.pNext = &ray_query;
  ray_query.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR;
  ray_query.rayQuery = VK_TRUE;
  if (offered.ray_query) v13.pNext = &acceleration;
}

}  // namespace gnomon::gpu
