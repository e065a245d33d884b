// Tracer "ray_query": the device's own acceleration structures and ray queries (VK_KHR_ray_query).
#include "common/clock.h"
#include "gpu/tracers/tracer.h"
#include "spirv/trace_ray_query_comp.h"

namespace gnomon::gpu {
namespace {

// The extension's functions, which the loader does not export.
struct RayFunctions {
  PFN_vkCreateAccelerationStructureKHR create = nullptr;
  PFN_vkDestroyAccelerationStructureKHR destroy = nullptr;
  PFN_vkGetAccelerationStructureBuildSizesKHR build_sizes = nullptr;
  PFN_vkCmdBuildAccelerationStructuresKHR build = nullptr;
  PFN_vkGetAccelerationStructureDeviceAddressKHR address = nullptr;

  explicit RayFunctions(VkDevice device) {
    const auto load = [device](auto& function, const char* name) {
      function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(vkGetDeviceProcAddr(device, name));
    };
    load(create, "vkCreateAccelerationStructureKHR");
    load(destroy, "vkDestroyAccelerationStructureKHR");
    load(build_sizes, "vkGetAccelerationStructureBuildSizesKHR");
    load(build, "vkCmdBuildAccelerationStructuresKHR");
    load(address, "vkGetAccelerationStructureDeviceAddressKHR");
  }
};

constexpr VkBufferUsageFlags kBuildInput = VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR;

class AccelerationStructure {
 public:
  AccelerationStructure() = default;
  AccelerationStructure(AccelerationStructure&& other) noexcept { *this = std::move(other); }
  AccelerationStructure& operator=(AccelerationStructure&& other) noexcept {
    std::swap(device_, other.device_);
    std::swap(destroy_, other.destroy_);
    std::swap(handle_, other.handle_);
    std::swap(buffer_, other.buffer_);
    std::swap(address_, other.address_);
    return *this;
  }
  ~AccelerationStructure() {
    if (!handle_) return;
    device_->retire(
        [device = device_->handle(), destroy = destroy_, handle = handle_] { destroy(device, handle, nullptr); });
  }

  // Blocking. Geometry i has counts[i] primitives.
  static Result<AccelerationStructure> build(const DevicePtr& device, const RayFunctions& rays,
                                             VkAccelerationStructureTypeKHR type,
                                             std::span<const VkAccelerationStructureGeometryKHR> geometries,
                                             std::span<const uint32_t> counts,
                                             std::span<const uint32_t> first_bytes);

  VkDeviceAddress address() const { return address_; }
  uint64_t memory_bytes() const { return buffer_.bytes(); }

 private:
  DevicePtr device_;
  PFN_vkDestroyAccelerationStructureKHR destroy_ = nullptr;
  VkAccelerationStructureKHR handle_ = VK_NULL_HANDLE;
  Buffer buffer_;
  VkDeviceAddress address_ = 0;
};

Result<AccelerationStructure> AccelerationStructure::build(
    const DevicePtr& device, const RayFunctions& rays, VkAccelerationStructureTypeKHR type,
    std::span<const VkAccelerationStructureGeometryKHR> geometries, std::span<const uint32_t> counts,
    std::span<const uint32_t> first_bytes) {
  VkAccelerationStructureBuildGeometryInfoKHR info{};
  info.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR;
  info.type = type;
  info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
  info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
  info.geometryCount = static_cast<uint32_t>(geometries.size());
  info.pGeometries = geometries.data();
  VkAccelerationStructureBuildSizesInfoKHR sizes{};
  sizes.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR;
  rays.build_sizes(device->handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info, counts.data(), &sizes);

  AccelerationStructure out;
  out.device_ = device;
  out.destroy_ = rays.destroy;
  auto buffer = Buffer::create(device, sizes.accelerationStructureSize,
                               VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR, MemoryUse::device);
  if (!buffer) return buffer.error();
  out.buffer_ = std::move(*buffer);
  VkAccelerationStructureCreateInfoKHR create{};
  create.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR;
  create.buffer = out.buffer_.handle();
  create.size = sizes.accelerationStructureSize;
  create.type = type;
  if (const VkResult r = rays.create(device->handle(), &create, nullptr, &out.handle_); r != VK_SUCCESS)
    return vulkan_error(r, "creating an acceleration structure");

  constexpr uint64_t kScratchAlignment = 256;  // the most that the extension lets a device ask for
  const auto scratch = Buffer::create(device, sizes.buildScratchSize + kScratchAlignment, 0, MemoryUse::device);
  if (!scratch) return scratch.error();
  info.dstAccelerationStructure = out.handle_;
  info.scratchData.deviceAddress =
      (scratch->address() + kScratchAlignment - 1) / kScratchAlignment * kScratchAlignment;
  std::vector<VkAccelerationStructureBuildRangeInfoKHR> ranges;
  for (size_t i = 0; i < counts.size(); ++i) ranges.push_back({counts[i], first_bytes[i], 0, 0});
  const VkAccelerationStructureBuildRangeInfoKHR* range = ranges.data();
  const auto built = run_now(device, [&](VkCommandBuffer commands) { rays.build(commands, 1, &info, &range); });
  if (!built) return built.error();
  VkAccelerationStructureDeviceAddressInfoKHR address{};
  address.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR;
  address.accelerationStructure = out.handle_;
  out.address_ = rays.address(device->handle(), &address);
  return out;
}

// As shaders/trace_ray_query.comp declares it, after the addresses of the masks and of valid_bits.
struct Push {
  VkDeviceAddress top = 0;
  uint32_t first_masked_triangle = 0;
  uint32_t reserved = 0;
};

class RayQueryScene : public TracedScene {
 public:
  RayQueryScene(AccelerationStructure bottom, AccelerationStructure top, uint32_t first_masked)
      : bottom_(std::move(bottom)), top_(std::move(top)), push_{top_.address(), first_masked, 0} {}
  uint64_t memory_bytes() const override { return bottom_.memory_bytes() + top_.memory_bytes(); }
  std::span<const std::byte> push_constants() const override { return std::as_bytes(std::span(&push_, 1)); }

 private:
  AccelerationStructure bottom_, top_;
  Push push_;
};

class RayQueryTracer : public Tracer {
 public:
  RayQueryTracer(DevicePtr device, StructureBuildsPtr builds)
      : device_(std::move(device)),
        rays_(device_->handle()),
        hierarchies_(make_bvh_tracer(device_, std::move(builds))) {}

  std::string_view name() const override { return "ray_query"; }
  TraceShader shader() const override { return {trace_ray_query_comp}; }
  Result<std::unique_ptr<TracedScene>> build_hierarchy(const TracerInput& input) const override {
    return hierarchies_->build(input);
  }

  Result<std::unique_ptr<TracedScene>> build(const TracerInput& input) const override {
    const TimePoint start = Clock::now();
    AccelerationStructure bottom, top;
    if (!input.mesh.triangles.empty()) {
      auto built = build_bottom(input);
      if (!built) return built.error();
      bottom = std::move(*built);
      built = build_top(bottom);
      if (!built) return built.error();
      top = std::move(*built);
    }
    std::unique_ptr<TracedScene> scene =
        std::make_unique<RayQueryScene>(std::move(bottom), std::move(top), input.mesh.opaque_count);
    scene->build_seconds = to_seconds(Clock::now() - start);
    return scene;
  }

 private:
  // One geometry has the opaque triangles, the other those whose alpha test the shader makes.
  Result<AccelerationStructure> build_bottom(const TracerInput& input) const {
    VkAccelerationStructureGeometryKHR geometry{};
    geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    VkAccelerationStructureGeometryTrianglesDataKHR& triangles = geometry.geometry.triangles;
    triangles.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR;
    triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
    triangles.vertexData.deviceAddress = input.positions.address();
    triangles.vertexStride = sizeof(glm::vec3);
    triangles.maxVertex = static_cast<uint32_t>(input.mesh.positions.size()) - 1;
    triangles.indexType = VK_INDEX_TYPE_UINT32;
    triangles.indexData.deviceAddress = input.triangles.address();

    const uint32_t opaque = input.mesh.opaque_count;
    const uint32_t masked = static_cast<uint32_t>(input.mesh.triangles.size()) - opaque;
    std::vector<VkAccelerationStructureGeometryKHR> geometries;
    std::vector<uint32_t> counts, first_bytes;
    const auto add = [&](VkGeometryFlagsKHR flags, uint32_t first, uint32_t count) {
      if (count == 0) return;
      geometry.flags = flags;
      geometries.push_back(geometry);
      counts.push_back(count);
      first_bytes.push_back(first * static_cast<uint32_t>(sizeof(glm::uvec3)));
    };
    add(VK_GEOMETRY_OPAQUE_BIT_KHR, 0, opaque);
    add(0, opaque, masked);
    return AccelerationStructure::build(device_, rays_, VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR, geometries,
                                        counts, first_bytes);
  }

  Result<AccelerationStructure> build_top(const AccelerationStructure& bottom) const {
    VkAccelerationStructureInstanceKHR instance{};
    instance.transform.matrix[0][0] = instance.transform.matrix[1][1] = instance.transform.matrix[2][2] = 1.0f;
    instance.mask = 0xff;
    instance.accelerationStructureReference = bottom.address();
    const auto instances = upload(device_, std::as_bytes(std::span(&instance, 1)), kBuildInput);
    if (!instances) return instances.error();
    VkAccelerationStructureGeometryKHR geometry{};
    geometry.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR;
    geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    geometry.geometry.instances.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR;
    geometry.geometry.instances.data.deviceAddress = instances->address();
    const uint32_t count = 1, first_byte = 0;
    return AccelerationStructure::build(device_, rays_, VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR,
                                        std::span(&geometry, 1), std::span(&count, 1), std::span(&first_byte, 1));
  }

  DevicePtr device_;
  RayFunctions rays_;
  std::unique_ptr<Tracer> hierarchies_;
};

}  // namespace

Result<std::unique_ptr<Tracer>> make_ray_query_tracer(const DevicePtr& device, StructureBuildsPtr builds) {
  if (!device->features().ray_query)
    return Error{"tracer 'ray_query': device '" + device->info().name + "' offers no ray queries"};
  return std::unique_ptr<Tracer>(std::make_unique<RayQueryTracer>(device, std::move(builds)));
}

}  // namespace gnomon::gpu
