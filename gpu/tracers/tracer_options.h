// Options of tracers.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>

#include "gpu/builds/structure_builds.h"
#include "gpu/vulkan/instance.h"

namespace gnomon::gpu {

// The trace pass with a tracer, as SPIR-V and as it wants to be run.
struct TraceShader {
  std::span<const uint32_t> spirv;  // words that live as long as the program
  uint32_t lanes = 0;               // of its subgroups; 0: any number
  uint32_t tiles = 1;               // that a workgroup traces, side by side
  uint32_t texel_buffers = 0;  // that it reads as texels, of what its tracer built; 0: it was not made for texels
};

struct TracerOptions {
  std::filesystem::path cache_folder;  // for the results of builds; if empty, no cache
  // Most that the folder may hold; what was used least recently leaves first. Read whenever something is kept. nullptr: no
  // limit.
  std::shared_ptr<const std::atomic<uint64_t>> cache_bytes = nullptr;
  // Memory budget of a scene's light buffers; a scene with area lights has half of it for their middles and half for
  // their extents. 0: for each by the number of lights, and by the room that the device has (light_buffer_room).
  uint64_t light_buffer_bytes = 0;
  // The most that light_buffer_room may be.
  uint64_t most_light_buffer_room = UINT64_MAX;
  StructureBuildsPtr builds = builds_here();
  // Instead of the ones for the device's subgroups, which load no texels: for tests, on devices that load none.
  std::optional<TraceShader> light_buffer_shader = {};
  std::optional<TraceShader> light_buffer_soft_shader = {};
};

// What the light buffers of a scene may take on a device, in bytes, if that is more than its number of lights asks for: a
// small part of a GPU's own memory, as many scenes share it; nothing on a processor, whose memory everything shares.
inline uint64_t light_buffer_room(const PhysicalDevice& device, const TracerOptions& options) {
  constexpr uint64_t kScenes = 64;
  if (device.type == VK_PHYSICAL_DEVICE_TYPE_CPU) return 0;
  return std::min(device.local_bytes / kScenes, options.most_light_buffer_room);
}

inline uint64_t cache_limit(const TracerOptions& options) {
  return options.cache_bytes ? options.cache_bytes->load() : UINT64_MAX;
}

}  // namespace gnomon::gpu
