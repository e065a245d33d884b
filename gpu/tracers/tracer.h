// A tracer: answers whether a shadow segment meets geometry. On the device it is a shader, shaders/trace_NAME*.comp, that
// includes trace.glsl and gives it
//   bool occluded(vec3 origin, vec3 direction)   // some geometry at origin + t * direction, 0 < t < 1
// or replaces that file, as trace_light_buffer.glsl does; shaders/tracers/ holds what several of them share. On the host
// it builds, once for each scene, what that shader reads.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "gpu/exact_cpp.h"
#include "gpu/tracers/tracer_options.h"
#include "gpu/vulkan/resources.h"
#include "scenes/world_mesh.h"

namespace gnomon::gpu {

// Statistics of a tracer that sorts triangles into lists for each light; zeros for other tracers.
struct ListStatistics {
  double average = 0;    // entries of a list
  uint32_t longest = 0;  // entries of the longest list
  bool from_cache = false;
  bool not_kept = false;  // the cache did not take what was built
};

// A tracer's data on the device for one scene. Immutable.
class TracedScene {
 public:
  virtual ~TracedScene() = default;
  virtual uint64_t memory_bytes() const = 0;
  // The push constants after the addresses of the masks and the valid_bits; at most kPushConstantBytes - 16 bytes.
  virtual std::span<const std::byte> push_constants() const = 0;
  // What the shader reads as texels; VK_NULL_HANDLE where it reads nothing so.
  virtual VkDescriptorSet texels() const { return VK_NULL_HANDLE; }

  double build_seconds = 0;
  ListStatistics list_statistics;
};

// Observes a long build, and can stop it.
struct BuildWatch {
  std::function<void(size_t light, double share)> progress = {};  // of that light's work; on the building thread
  std::stop_token stop = {};                                      // after a request to stop, the build fails soon
};

// The input of a tracer's build. The buffers are those of the resident scene and outlive the result.
struct TracerInput {
  const scenes::Scene& scene;
  const scenes::WorldMesh& mesh;
  std::span<const exact::TracedLight> lights;
  bool lights_as_loaded = true;  // false: the lights have moved, and the scene's content hash does not cover them
  const Buffer& positions;
  const Buffer& triangles;
  BuildWatch watch = {};
};

class Tracer {
 public:
  virtual ~Tracer() = default;
  virtual std::string_view name() const = 0;
  virtual TraceShader shader() const = 0;
  // Whether the tracer's data is valid only for the lights that it was built for.
  virtual bool builds_for_lights() const { return false; }
  // The shader that traces area lights by what build() makes for lights with a radius; nullopt: hierarchies trace them.
  virtual std::optional<TraceShader> soft_shader() const { return std::nullopt; }
  // Blocking; any thread. Error: out of memory, device lost, stopped.
  virtual Result<std::unique_ptr<TracedScene>> build(const TracerInput& input) const = 0;
  // Whether build() makes the structure of the tracer "bvh".
  virtual bool is_hierarchy() const { return false; }
  // The structure of the tracer "bvh", for what this one does not trace: lights that it was not built for, and area
  // lights. Blocking; any thread. Error: out of memory, device lost.
  virtual Result<std::unique_ptr<TracedScene>> build_hierarchy(const TracerInput& input) const = 0;
  // As build, but only if it is quick, because the build is short or its result is cached; nullptr if a long build is
  // needed.
  virtual Result<std::unique_ptr<TracedScene>> build_at_once(const TracerInput& input) const {
    return build(input);
  }
};

// All tracers, by name.
inline constexpr std::array<std::string_view, 3> kTracers{"bvh", "light_buffer", "ray_query"};

// Error: `name` is neither "auto" nor one of kTracers; whether a device supports it is not looked at.
Result<void> check_tracer_name(std::string_view name);

// `name`: "bvh", "light_buffer", "ray_query", or "auto" for the fastest that this device can run. Error: there is no
// such tracer, or the device does not support it.
Result<std::unique_ptr<Tracer>> make_tracer(std::string_view name, const DevicePtr& device,
                                            const TracerOptions& options = {});

std::unique_ptr<Tracer> make_bvh_tracer(const DevicePtr& device, StructureBuildsPtr builds);
// Error: the device offers no subgroups of 4 to 128 lanes with ballots and votes, which its shaders are written for.
Result<std::unique_ptr<Tracer>> make_light_buffer_tracer(const DevicePtr& device, const TracerOptions& options);
Result<std::unique_ptr<Tracer>> make_ray_query_tracer(const DevicePtr& device, StructureBuildsPtr builds);

}  // namespace gnomon::gpu
