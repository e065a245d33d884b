// The features that Gnomon needs of a Vulkan device, and those that it uses if the device offers them.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "gpu/vulkan/vulkan.h"

namespace gnomon::gpu {

// The subgroups of compute shaders, in lanes.
struct SubgroupFeatures {
  uint32_t usual = 0;            // without a request
  uint32_t least = 0, most = 0;  // what a pipeline may request, powers of two; `usual` where it may request nothing
  bool requests = false;         // whether a pipeline may request a size, and that all lanes take part
  bool ballots_and_votes = false;
};

struct DeviceFeatures {
  bool ray_query = false;
  bool int64 = false;           // 64-bit integers in shaders
  bool atomic_int64 = false;    // and atomic operations on those in buffers
  bool unified_memory = false;  // device memory is host memory, so that nothing needs staging
  SubgroupFeatures subgroups;
  uint32_t max_image_side = 0;  // pixels
  uint32_t max_texels = 0;      // of a buffer's view
  uint32_t max_sets = 0;        // of descriptors, that a pipeline may bind
  double timestamp_period_ns = 0;

  // Whether shaders run on vector units of a processor, whose lanes load one after the other: by how few there are.
  bool has_vector_units() const { return subgroups.usual <= 16; }
  // Whether shaders with BY_TEXELS (shaders/texels.glsl) are the faster ones, and possible: a view shows 512 MiB by words
  // then, and 2 GiB by texels of four.
  bool loads_texels() const {
    return has_vector_units() && max_texels >= kEnoughTexels && max_sets >= kSetsOfATrace;
  }
  // Of a shader's words that were compiled with it and without the ones to run.
  std::span<const uint32_t> choose(std::span<const uint32_t> by_texels, std::span<const uint32_t> other) const {
    return loads_texels() ? by_texels : other;
  }
  static constexpr uint32_t kEnoughTexels = uint32_t{1} << 27;
  static constexpr uint32_t kSetsOfATrace = 6;
};

// A readable list of the required features that the device lacks; empty if it is usable.
std::string missing_features(VkPhysicalDevice device);

DeviceFeatures query_features(VkPhysicalDevice device);

// The device's PCI address as in sysfs; empty if it is on no PCI bus or does not report its address.
std::string pci_address(VkPhysicalDevice device);

// The feature chain that the VkDevice is created with. Not copyable, because the structs point at each other.
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
