// A tracer: answers whether a shadow segment meets geometry. On the device it is a shader that defines
//   bool occluded(vec3 origin, vec3 direction)   // some geometry at origin + t * direction, 0 < t < 1
// (shaders/tracers/NAME.glsl, included by shaders/trace_NAME.comp); on the host it builds, once for each scene, what
// that shader reads.
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "gpu/exact_cpp.h"
#include "gpu/tracers/tracer_options.h"
#include "gpu/vulkan/resources.h"
#include "scenes/world_mesh.h"

namespace gnomon::gpu {

// Of a tracer that sorts triangles into lists for each light; zeros for others.
struct ListStatistics {
  double average = 0;    // entries of a list
  uint32_t longest = 0;  // of them in one list
  bool from_cache = false;
};

// What a tracer keeps on the device for one scene.
class TracedScene {
 public:
  virtual ~TracedScene() = default;
  virtual uint64_t memory_bytes() const = 0;
  // Follow the addresses of the masks and the valid_bits; at most kPushConstantBytes - 16.
  virtual std::span<const std::byte> push_constants() const = 0;

  double build_seconds = 0;
  ListStatistics list_statistics;
};

// Who follows a long build, and may end it.
struct BuildWatch {
  std::function<void(size_t light, double share)> progress = {};  // of that light's work; on the building thread
  std::stop_token stop = {};                                      // once stopped, the build fails soon
};

// What a tracer builds from. The buffers are those of the resident scene and outlive what is built.
struct TracerInput {
  const scenes::Scene& scene;
  const scenes::WorldMesh& mesh;
  std::span<const exact::TracedLight> lights;
  bool lights_as_loaded = true;  // false: they have moved since, the scene's content hash does not know them
  const Buffer& positions;
  const Buffer& triangles;
  BuildWatch watch = {};
};

class Tracer {
 public:
  virtual ~Tracer() = default;
  virtual std::string_view name() const = 0;
  virtual std::span<const uint32_t> shader() const = 0;  // the trace pass with this tracer
  // Whether what it builds answers for the lights that it was built for and no others.
  virtual bool builds_for_lights() const { return false; }
  // Blocking; any thread. Error: out of memory, device lost, stopped.
  virtual Result<std::unique_ptr<TracedScene>> build(const TracerInput& input) const = 0;
  // What can be had without a long build: everything, or what was kept of an earlier one. Null: it has to be built. As
  // above.
  virtual Result<std::unique_ptr<TracedScene>> build_at_once(const TracerInput& input) const {
    return build(input);
  }
};

// `name`: "bvh", "light_buffer", "ray_query", or "auto" for the fastest that this device can run. Error: no such tracer, or
// the device does not offer it.
Result<std::unique_ptr<Tracer>> make_tracer(std::string_view name, const DevicePtr& device,
                                            const TracerOptions& options = {});

std::unique_ptr<Tracer> make_bvh_tracer(const DevicePtr& device);
// Error: the device's subgroups are neither of 8 nor of 32 lanes, which its shaders are written for.
Result<std::unique_ptr<Tracer>> make_light_buffer_tracer(const DevicePtr& device, const TracerOptions& options);
Result<std::unique_ptr<Tracer>> make_ray_query_tracer(const DevicePtr& device);

}  // namespace gnomon::gpu
