// A pass: one step of a frame. It declares by name what it reads and writes; FramePlan wires the rest.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "common/sample_counts.h"
#include "gpu/scene/frame_uniforms.h"
#include "gpu/scene/resident_scene.h"
#include "gpu/vulkan/pipeline.h"
#include "gpu/vulkan/resources.h"

namespace gnomon::gpu {

// What a frame is to show.
struct FrameView {
  CameraView camera;
  TileGrid grid;
  LightSet untraced = {};
  SampleCounts samples = {};  // more than one per light (a soft frame) only if the scene has area lights
};

// How a pass uses a resource. An image may be a target, sampled or (compute) storage_write.
enum class Use {
  color_target,
  depth_target,
  sampled,
  storage_read,
  texel_read,  // of a buffer: by its address, and as texels
  storage_write,
  storage_update,  // read and written
  indirect,
  indirect_read,  // the same buffer also read by the shader
  vertex_read,
  copy_source,
  copy_target,
  fill_target
};

constexpr bool writes(Use use) {
  return use == Use::color_target || use == Use::depth_target || use == Use::storage_write ||
         use == Use::storage_update || use == Use::copy_target || use == Use::fill_target;
}

// The largest frame that a slot's resources can hold.
struct Capacity {
  uint32_t width = 0, height = 0, planes = 0;
  uint32_t cluster_chunks = 0, triangles = 0;          // of what rests in the scene
  uint32_t moving_vertices = 0, moving_triangles = 0;  // of what moves
  uint32_t sample_points = 0;                          // of all area lights, in soft frames

  bool holds(const Capacity& other) const {
    return width >= other.width && height >= other.height && planes >= other.planes &&
           cluster_chunks >= other.cluster_chunks && triangles >= other.triangles &&
           moving_vertices >= other.moving_vertices && moving_triangles >= other.moving_triangles &&
           sample_points >= other.sample_points;
  }
  Capacity grown_to(const Capacity& other) const {
    return {std::max(width, other.width),
            std::max(height, other.height),
            std::max(planes, other.planes),
            std::max(cluster_chunks, other.cluster_chunks),
            std::max(triangles, other.triangles),
            std::max(moving_vertices, other.moving_vertices),
            std::max(moving_triangles, other.moving_triangles),
            std::max(sample_points, other.sample_points)};
  }
  TileGrid grid() const { return {width, height, planes}; }
};

// What to allocate for a resource: an image if `format` is set, else a buffer. The first pass that uses the resource
// states it: one that writes it, or one that reads what the host has written (MemoryUse::upload).
struct ResourceSpec {
  VkFormat format = VK_FORMAT_UNDEFINED;
  std::function<uint64_t(const Capacity&)> bytes;
  MemoryUse memory = MemoryUse::device;
  bool given = false;  // the caller provides a buffer that outlives the frame, see FramePlan::give
};
inline ResourceSpec given_buffer() { return {{}, {}, MemoryUse::device, true}; }

// The capacity that one frame needs.
inline Capacity frame_size(const ResidentScene& scene, const TileGrid& grid) {
  return {grid.width,
          grid.height,
          grid.planes,
          scene.clusters().chunk_count(),
          scene.triangle_count(),
          scene.moving_size().vertices,
          scene.moving_size().triangles,
          grid.planes > scene.light_count() ? scene.area_lights().most_points() : 0};
}

struct Port {
  std::string_view resource;  // names live as long as the program
  Use use;
  ResourceSpec spec = {};
};

struct BoundPort {
  const Image* image = nullptr;
  const Buffer* buffer = nullptr;
  VkDescriptorSet texels = VK_NULL_HANDLE;  // of a texel_read, where the device loads texels
};

// A frame may be traced in bands of tile rows, each a submit of its own. The bands in which a pass runs.
enum class RunsIn { first_band, every_band, last_band };

// One band of a frame. The first band may have no rows: then it only rasterises the frame.
struct Band {
  TileRows rows;
  bool first = true, last = true;

  bool has(RunsIn bands) const {
    return bands == RunsIn::first_band ? first : bands == RunsIn::last_band ? last : true;
  }
};

// What a pass is given to record one band of a frame.
struct FrameContext {
  VkCommandBuffer commands = VK_NULL_HANDLE;
  VkDescriptorSet descriptors = VK_NULL_HANDLE;
  std::span<const BoundPort> ports;  // in the order of Pass::ports
  const ResidentScene& scene;
  const PosedScene& posed;  // the scene at this frame's time
  uint32_t slot = 0;        // of the frames in flight
  TileGrid grid;            // this frame's, within the capacity
  LightSet untraced;        // lights that are lit everywhere in the mask
  SampleCounts samples;     // as in FrameView
  TileRows rows;            // this band's

  Capacity size() const { return frame_size(scene, grid); }
};

// Immutable; shared by all frame slots.
class Pass {
 public:
  virtual ~Pass() = default;
  virtual std::string_view name() const = 0;
  virtual std::vector<Port> ports() const = 0;
  virtual const PassLayout* layout() const = 0;  // nullptr if the pass binds nothing
  virtual RunsIn runs_in() const { return RunsIn::first_band; }
  // Whether the pass leaves moving lights to another one: its uniforms have them with a reach of nothing, so that they are
  // lit nowhere. Only in plans for scenes in motion.
  virtual bool for_resting_lights() const { return false; }
  virtual void record(const FrameContext& frame) const = 0;
};

class Tracer;

// What the frames of a plan have that others go without.
struct PlanKind {
  bool motion = false;     // something moves in the scene
  bool soft = false;       // several points of each area light are traced
  bool occlusion = false;  // that of the ambient light is counted
  friend bool operator==(const PlanKind&, const PlanKind&) = default;
};

// Makes the passes of that name; some names stand for several passes, and for more of them in plans of some kinds.
// `tracer` may be null if nothing is traced. Error: there is no such pass (the message lists the names), or a pass
// traces and `tracer` is null.
using Passes = std::vector<std::unique_ptr<Pass>>;
Result<Passes> make_passes(std::string_view name, const DevicePtr& device, const Tracer* tracer, PlanKind kind);

}  // namespace gnomon::gpu
