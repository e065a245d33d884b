#include "gpu/vulkan/instance.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <mutex>

#include "common/log.h"
#include "gpu/vulkan/device_features.h"

namespace gnomon::gpu {
namespace {

constexpr const char* kValidationLayer = "VK_LAYER_KHRONOS_validation";

bool layer_installed(std::string_view wanted) {
  uint32_t count = 0;
  vkEnumerateInstanceLayerProperties(&count, nullptr);
  std::vector<VkLayerProperties> layers(count);
  vkEnumerateInstanceLayerProperties(&count, layers.data());
  return std::any_of(layers.begin(), layers.end(), [&](const auto& l) { return wanted == l.layerName; });
}

std::string lower(std::string_view text) {
  std::string s(text);
  std::transform(s.begin(), s.end(), s.begin(), [](unsigned char c) { return std::tolower(c); });
  return s;
}

std::string_view type_name(VkPhysicalDeviceType type) {
  switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU: return "discrete";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU: return "integrated";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU: return "virtual";
    case VK_PHYSICAL_DEVICE_TYPE_CPU: return "cpu";
    default: return "other";
  }
}

int preference(const PhysicalDevice& device) {
  constexpr std::array<std::string_view, 5> order{"discrete", "integrated", "virtual", "cpu", "other"};
  const auto at = std::find(order.begin(), order.end(), type_name(device.type));
  return static_cast<int>(at - order.begin());
}

bool fits(const PhysicalDevice& device, size_t index, std::string_view selector) {
  if (selector.empty() || selector == type_name(device.type)) return true;
  size_t wanted = 0;
  const char* end = selector.data() + selector.size();
  const auto parsed = std::from_chars(selector.data(), end, wanted);
  if (parsed.ec == std::errc{} && parsed.ptr == end) return wanted == index;
  return lower(device.name).find(lower(selector)) != std::string::npos;
}

Error no_device(const std::vector<PhysicalDevice>& devices, std::string_view selector) {
  std::string text = selector.empty() ? "no usable Vulkan device" : "no usable Vulkan device fits '";
  if (!selector.empty()) text += std::string(selector) + "'";
  text += devices.empty() ? "; this machine has none" : "; this machine has";
  for (size_t i = 0; i < devices.size(); ++i) {
    text += (i ? ", " : " ") + std::to_string(i) + " '" + devices[i].name + "' (" +
            std::string(type_name(devices[i].type)) + ")";
    if (!devices[i].missing.empty()) text += " without " + devices[i].missing;
  }
  return {text};
}

uint64_t local_bytes(VkPhysicalDevice device) {
  VkPhysicalDeviceMemoryProperties memory{};
  vkGetPhysicalDeviceMemoryProperties(device, &memory);
  uint64_t most = 0;
  for (const VkMemoryHeap& heap : std::span(memory.memoryHeaps).first(memory.memoryHeapCount))
    if ((heap.flags & VK_MEMORY_HEAP_DEVICE_LOCAL_BIT) != 0) most = std::max<uint64_t>(most, heap.size);
  return most;
}

PhysicalDevice describe(VkPhysicalDevice handle) {
  VkPhysicalDeviceDriverProperties driver{};
  driver.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES;
  VkPhysicalDeviceProperties2 properties{};
  properties.sType = VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2;
  properties.pNext = &driver;
  vkGetPhysicalDeviceProperties2(handle, &properties);
  PhysicalDevice info;
  info.handle = handle;
  info.name = properties.properties.deviceName;
  info.driver = std::string(driver.driverName) + " " + driver.driverInfo;
  info.pci_address = pci_address(handle);
  info.type = properties.properties.deviceType;
  info.api_version = properties.properties.apiVersion;
  info.missing = missing_features(handle);
  info.local_bytes = local_bytes(handle);
  return info;
}

// The end of the last instance unloads the drivers. NVIDIA's (580.159.04) takes room for thread-local data of the process
// each time that it is loaded and returns none: the 31st instance would find no driver. So one instance is kept.
void keep_drivers_loaded(const VkInstanceCreateInfo& create) {
  static std::mutex mutex;
  static VkInstance kept = VK_NULL_HANDLE;
  const std::lock_guard lock(mutex);
  if (kept == VK_NULL_HANDLE && vkCreateInstance(&create, nullptr, &kept) != VK_SUCCESS) kept = VK_NULL_HANDLE;
}

}  // namespace

Result<std::unique_ptr<Instance>> Instance::create(ValidationOptions validation) {
  std::unique_ptr<Instance> self(new Instance(std::move(validation)));
  VkApplicationInfo application{};
  application.sType = VK_STRUCTURE_TYPE_APPLICATION_INFO;
  application.pApplicationName = "gnomon";
  application.apiVersion = VK_API_VERSION_1_3;
  VkInstanceCreateInfo create{};
  create.sType = VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO;
  create.pApplicationInfo = &application;
  keep_drivers_loaded(create);

  const VkValidationFeatureEnableEXT synchronization = VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT;
  VkValidationFeaturesEXT features{};
  features.sType = VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT;
  features.enabledValidationFeatureCount = 1;
  features.pEnabledValidationFeatures = &synchronization;
  const std::array extensions{VK_EXT_DEBUG_UTILS_EXTENSION_NAME};
  if (self->validation_.enabled) {
    if (!layer_installed(kValidationLayer)) return Error{std::string(kValidationLayer) + " is not installed"};
    create.enabledLayerCount = 1;
    create.ppEnabledLayerNames = &kValidationLayer;
    create.enabledExtensionCount = extensions.size();
    create.ppEnabledExtensionNames = extensions.data();
    create.pNext = &features;
  }
  if (const VkResult r = vkCreateInstance(&create, nullptr, &self->instance_); r != VK_SUCCESS)
    return vulkan_error(r, "starting Vulkan");

  if (self->validation_.enabled) {
    VkDebugUtilsMessengerCreateInfoEXT messenger{};
    messenger.sType = VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT;
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType =
        VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
    messenger.pfnUserCallback = &Instance::on_message;
    messenger.pUserData = self.get();
    const auto listen = reinterpret_cast<PFN_vkCreateDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(self->instance_, "vkCreateDebugUtilsMessengerEXT"));
    if (const VkResult r = listen(self->instance_, &messenger, nullptr, &self->messenger_); r != VK_SUCCESS)
      return vulkan_error(r, "listening to the validation layer");
  }
  return self;
}

Instance::~Instance() {
  if (messenger_) {
    const auto stop = reinterpret_cast<PFN_vkDestroyDebugUtilsMessengerEXT>(
        vkGetInstanceProcAddr(instance_, "vkDestroyDebugUtilsMessengerEXT"));
    stop(instance_, messenger_, nullptr);
  }
  if (instance_) vkDestroyInstance(instance_, nullptr);
}

VkBool32 Instance::on_message(VkDebugUtilsMessageSeverityFlagBitsEXT, VkDebugUtilsMessageTypeFlagsEXT,
                              const VkDebugUtilsMessengerCallbackDataEXT* data, void* self) {
  auto& instance = *static_cast<Instance*>(self);
  ++instance.messages_;
  if (instance.validation_.on_message) {
    instance.validation_.on_message(data->pMessage);
  } else {
    log::warning("vulkan validation", {{"message", data->pMessage}});
  }
  return VK_FALSE;
}

std::vector<PhysicalDevice> list_devices(const Instance& instance) {
  uint32_t count = 0;
  vkEnumeratePhysicalDevices(instance.handle(), &count, nullptr);
  std::vector<VkPhysicalDevice> handles(count);
  vkEnumeratePhysicalDevices(instance.handle(), &count, handles.data());
  std::vector<PhysicalDevice> devices;
  for (VkPhysicalDevice handle : handles) devices.push_back(describe(handle));
  return devices;
}

Result<PhysicalDevice> choose_device(const Instance& instance, std::string_view selector) {
  const std::vector<PhysicalDevice> devices = list_devices(instance);
  const PhysicalDevice* best = nullptr;
  for (size_t i = 0; i < devices.size(); ++i) {
    if (!devices[i].missing.empty() || !fits(devices[i], i, selector)) continue;
    if (!best || preference(devices[i]) < preference(*best)) best = &devices[i];
  }
  if (!best) return no_device(devices, selector);
  return *best;
}

}  // namespace gnomon::gpu
