// The Vulkan instance, its validation switch, and the choice of a device.
#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "common/result.h"
#include "gpu/vulkan/vulkan.h"

namespace gnomon::gpu {

struct ValidationOptions {
  bool enabled = false;
  // Any thread of the driver; warnings and errors only. Without one they go to the log.
  std::function<void(std::string_view message)> on_message;
};

class Instance {
 public:
  // Error: no Vulkan driver, or validation asked for and no VK_LAYER_KHRONOS_validation installed.
  static Result<std::unique_ptr<Instance>> create(ValidationOptions validation);
  ~Instance();
  Instance(const Instance&) = delete;
  Instance& operator=(const Instance&) = delete;

  VkInstance handle() const { return instance_; }
  uint64_t validation_messages() const { return messages_; }

 private:
  explicit Instance(ValidationOptions validation) : validation_(std::move(validation)) {}
  static VKAPI_ATTR VkBool32 VKAPI_CALL on_message(VkDebugUtilsMessageSeverityFlagBitsEXT severity,
                                                   VkDebugUtilsMessageTypeFlagsEXT types,
                                                   const VkDebugUtilsMessengerCallbackDataEXT* data, void* self);

  ValidationOptions validation_;
  VkInstance instance_ = VK_NULL_HANDLE;
  VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
  std::atomic<uint64_t> messages_ = 0;
};

// One physical device as it presents itself.
struct PhysicalDevice {
  VkPhysicalDevice handle = VK_NULL_HANDLE;
  std::string name;
  std::string driver;
  std::string pci_address;  // as sysfs names it: "0000:65:00.0"; empty: on no such bus
  VkPhysicalDeviceType type = VK_PHYSICAL_DEVICE_TYPE_OTHER;
  uint32_t api_version = 0;
  std::string missing;  // what Gnomon needs and the device lacks; empty: usable
};

std::vector<PhysicalDevice> list_devices(const Instance& instance);

// `selector`: "" the best usable one (discrete, integrated, virtual, cpu); an index; a type (cpu, discrete,
// integrated, virtual); or part of a name, upper and lower case alike. Error: none fits, with the list.
Result<PhysicalDevice> choose_device(const Instance& instance, std::string_view selector);

}  // namespace gnomon::gpu
