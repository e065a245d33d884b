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
  // Called on any thread of the driver, for warnings and errors only. If it is empty, they are logged.
  std::function<void(std::string_view message)> on_message;
};

// The drivers that the first one loads stay loaded until the process ends. Any thread.
class Instance {
 public:
  // Error: there is no Vulkan driver, or validation is enabled and VK_LAYER_KHRONOS_validation is not installed.
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

// A physical device and its properties.
struct PhysicalDevice {
  VkPhysicalDevice handle = VK_NULL_HANDLE;
  std::string name;
  std::string driver;
  std::string pci_address;  // as in sysfs: "0000:65:00.0"; empty if the device is on no PCI bus
  VkPhysicalDeviceType type = VK_PHYSICAL_DEVICE_TYPE_OTHER;
  uint32_t api_version = 0;
  uint64_t local_bytes = 0;  // of its largest memory of its own
  std::string missing;       // required features that the device lacks; empty if it is usable
};

std::vector<PhysicalDevice> list_devices(const Instance& instance);

// `selector`: "" for the best usable device (discrete before integrated, virtual, cpu); an index; a type (cpu,
// discrete, integrated, virtual); or part of a name, ignoring case. Error: no device matches; the message lists the
// devices.
Result<PhysicalDevice> choose_device(const Instance& instance, std::string_view selector);

}  // namespace gnomon::gpu
