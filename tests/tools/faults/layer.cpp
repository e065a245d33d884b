// A Vulkan layer that injects faults of the device into unchanged programs.
//
//   VK_ADD_LAYER_PATH=<folder of the manifest> VK_INSTANCE_LAYERS=VK_LAYER_GNOMON_faults GNOMON_FAULTS=<folder>
//
// A file in the folder GNOMON_FAULTS requests a fault:
//   lose_device     the next submit is executed, then every call on that device returns that it is lost (once)
//   lose_every      holds a number n: the same at each n-th submit
//   hang            this submit and all further ones on that device are dropped: their semaphores are never signalled
//   out_of_memory   allocations fail for lack of memory while the file exists
//   refuse_submits  submits fail for lack of memory while the file exists
#include <unistd.h>
#include <vulkan/vk_layer.h>
#include <vulkan/vulkan.h>

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <string>

namespace {

std::string order_file(const char* order) {
  const char* folder = std::getenv("GNOMON_FAULTS");
  return folder ? std::string(folder) + "/" + order : std::string();
}

bool ordered(const char* order) { return access(order_file(order).c_str(), F_OK) == 0; }
bool ordered_once(const char* order) { return unlink(order_file(order).c_str()) == 0; }

uint64_t ordered_number(const char* order) {
  uint64_t number = 0;
  std::ifstream(order_file(order)) >> number;
  return number;
}

// Dispatchable handles begin with a pointer that all handles of one device, or of one instance, share.
void* key_of(const void* handle) { return *static_cast<void* const*>(handle); }

struct Instance {
  VkInstance handle;
  PFN_vkGetInstanceProcAddr next;
  PFN_vkDestroyInstance destroy;
};

struct Device {
  PFN_vkGetDeviceProcAddr next;
  PFN_vkDestroyDevice destroy;
  PFN_vkQueueSubmit2 submit;
  PFN_vkWaitSemaphores wait;
  PFN_vkGetSemaphoreCounterValue counter;
  PFN_vkAllocateMemory allocate;
  std::atomic<bool> lost{false};
  std::atomic<bool> hung{false};
};

std::mutex mutex;
std::map<void*, Instance> instances;               // guarded by mutex
std::map<void*, std::shared_ptr<Device>> devices;  // guarded by mutex
std::atomic<uint64_t> submits{0};                  // of all devices since the start

std::shared_ptr<Device> device_of(const void* handle) {
  std::lock_guard lock(mutex);
  return devices.at(key_of(handle));
}

template <class Info>
Info* chain(const void* next, VkStructureType type) {
  for (auto* at = static_cast<const Info*>(next); at; at = static_cast<const Info*>(at->pNext)) {
    if (at->sType == type && at->function == VK_LAYER_LINK_INFO) return const_cast<Info*>(at);
  }
  return nullptr;
}

VkResult VKAPI_CALL create_instance(const VkInstanceCreateInfo* info, const VkAllocationCallbacks* allocator,
                                    VkInstance* out) {
  auto* link = chain<VkLayerInstanceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_INSTANCE_CREATE_INFO);
  if (!link) return VK_ERROR_INITIALIZATION_FAILED;
  const auto next = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  const auto create = reinterpret_cast<PFN_vkCreateInstance>(next(nullptr, "vkCreateInstance"));
  const VkResult result = create(info, allocator, out);
  if (result != VK_SUCCESS) return result;
  std::lock_guard lock(mutex);
  instances[key_of(*out)] = {*out, next, reinterpret_cast<PFN_vkDestroyInstance>(next(*out, "vkDestroyInstance"))};
  return result;
}

void VKAPI_CALL destroy_instance(VkInstance instance, const VkAllocationCallbacks* allocator) {
  Instance known;
  {
    std::lock_guard lock(mutex);
    const auto found = instances.find(key_of(instance));
    if (found == instances.end()) return;
    known = found->second;
    instances.erase(found);
  }
  known.destroy(instance, allocator);
}

template <class F>
void look_up(F& into, PFN_vkGetDeviceProcAddr next, VkDevice device, const char* name) {
  into = reinterpret_cast<F>(next(device, name));
}

VkResult VKAPI_CALL create_device(VkPhysicalDevice physical, const VkDeviceCreateInfo* info,
                                  const VkAllocationCallbacks* allocator, VkDevice* out) {
  auto* link = chain<VkLayerDeviceCreateInfo>(info->pNext, VK_STRUCTURE_TYPE_LOADER_DEVICE_CREATE_INFO);
  if (!link) return VK_ERROR_INITIALIZATION_FAILED;
  const auto next_instance = link->u.pLayerInfo->pfnNextGetInstanceProcAddr;
  const auto next = link->u.pLayerInfo->pfnNextGetDeviceProcAddr;
  link->u.pLayerInfo = link->u.pLayerInfo->pNext;
  VkInstance instance;
  {
    std::lock_guard lock(mutex);
    instance = instances.at(key_of(physical)).handle;
  }
  const auto create = reinterpret_cast<PFN_vkCreateDevice>(next_instance(instance, "vkCreateDevice"));
  const VkResult result = create(physical, info, allocator, out);
  if (result != VK_SUCCESS) return result;
  auto device = std::make_shared<Device>();
  device->next = next;
  look_up(device->destroy, next, *out, "vkDestroyDevice");
  look_up(device->submit, next, *out, "vkQueueSubmit2");
  look_up(device->wait, next, *out, "vkWaitSemaphores");
  look_up(device->counter, next, *out, "vkGetSemaphoreCounterValue");
  look_up(device->allocate, next, *out, "vkAllocateMemory");
  std::lock_guard lock(mutex);
  devices[key_of(*out)] = std::move(device);
  return result;
}

void VKAPI_CALL destroy_device(VkDevice handle, const VkAllocationCallbacks* allocator) {
  const auto device = device_of(handle);
  {
    std::lock_guard lock(mutex);
    devices.erase(key_of(handle));
  }
  device->destroy(handle, allocator);
}

VkResult VKAPI_CALL queue_submit(VkQueue queue, uint32_t count, const VkSubmitInfo2* infos, VkFence fence) {
  const auto device = device_of(queue);
  if (device->lost) return VK_ERROR_DEVICE_LOST;
  if (ordered("refuse_submits")) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  if (ordered_once("hang")) device->hung = true;
  if (device->hung) return VK_SUCCESS;
  const VkResult result = device->submit(queue, count, infos, fence);
  const uint64_t number = ++submits;
  const uint64_t every = ordered_number("lose_every");
  if (ordered_once("lose_device") || (every > 0 && number % every == 0)) device->lost = true;
  return result;
}

// Waits until the submitted work has really ended, so that nothing writes into freed memory, and then reports the loss.
VkResult VKAPI_CALL wait_semaphores(VkDevice handle, const VkSemaphoreWaitInfo* info, uint64_t timeout) {
  const auto device = device_of(handle);
  const VkResult result = device->wait(handle, info, timeout);
  return device->lost ? VK_ERROR_DEVICE_LOST : result;
}

VkResult VKAPI_CALL semaphore_counter(VkDevice handle, VkSemaphore semaphore, uint64_t* value) {
  const auto device = device_of(handle);
  return device->lost ? VK_ERROR_DEVICE_LOST : device->counter(handle, semaphore, value);
}

VkResult VKAPI_CALL allocate_memory(VkDevice handle, const VkMemoryAllocateInfo* info,
                                    const VkAllocationCallbacks* allocator, VkDeviceMemory* memory) {
  if (ordered("out_of_memory")) return VK_ERROR_OUT_OF_DEVICE_MEMORY;
  return device_of(handle)->allocate(handle, info, allocator, memory);
}

PFN_vkVoidFunction own(const char* name) {
  struct Entry {
    const char* name;
    PFN_vkVoidFunction function;
  };
#define GNOMON_OWN(vulkan_name, function) \
  { vulkan_name, reinterpret_cast<PFN_vkVoidFunction>(function) }
  static const Entry entries[] = {
      GNOMON_OWN("vkCreateInstance", create_instance),
      GNOMON_OWN("vkDestroyInstance", destroy_instance),
      GNOMON_OWN("vkCreateDevice", create_device),
      GNOMON_OWN("vkDestroyDevice", destroy_device),
      GNOMON_OWN("vkQueueSubmit2", queue_submit),
      GNOMON_OWN("vkWaitSemaphores", wait_semaphores),
      GNOMON_OWN("vkGetSemaphoreCounterValue", semaphore_counter),
      GNOMON_OWN("vkAllocateMemory", allocate_memory),
  };
#undef GNOMON_OWN
  for (const Entry& entry : entries) {
    if (std::strcmp(name, entry.name) == 0) return entry.function;
  }
  return nullptr;
}

PFN_vkVoidFunction VKAPI_CALL get_device_function(VkDevice device, const char* name) {
  if (std::strcmp(name, "vkGetDeviceProcAddr") == 0) {
    return reinterpret_cast<PFN_vkVoidFunction>(get_device_function);
  }
  if (const auto function = own(name)) return function;
  return device_of(device)->next(device, name);
}

PFN_vkVoidFunction VKAPI_CALL get_instance_function(VkInstance instance, const char* name) {
  if (std::strcmp(name, "vkGetInstanceProcAddr") == 0) {
    return reinterpret_cast<PFN_vkVoidFunction>(get_instance_function);
  }
  if (std::strcmp(name, "vkGetDeviceProcAddr") == 0) {
    return reinterpret_cast<PFN_vkVoidFunction>(get_device_function);
  }
  if (const auto function = own(name)) return function;
  if (!instance) return nullptr;
  PFN_vkGetInstanceProcAddr next;
  {
    std::lock_guard lock(mutex);
    next = instances.at(key_of(instance)).next;
  }
  return next(instance, name);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) VkResult VKAPI_CALL
vkNegotiateLoaderLayerInterfaceVersion(VkNegotiateLayerInterface* version) {
  version->loaderLayerInterfaceVersion = 2;
  version->pfnGetInstanceProcAddr = get_instance_function;
  version->pfnGetDeviceProcAddr = get_device_function;
  version->pfnGetPhysicalDeviceProcAddr = nullptr;
  return VK_SUCCESS;
}
