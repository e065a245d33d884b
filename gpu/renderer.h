// The interface to the GPU: views go in, packed tile masks come out. It knows no tenants and no sessions.
//
//   render loop -submit-> [frame slot: raster, trace, pack, read back] -completion thread-> on_done(FrameDone)
#pragma once

#include <bitset>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "common/clock.h"
#include "common/ids.h"
#include "common/packed_mask.h"
#include "common/result.h"
#include "common/sample_counts.h"
#include "scenes/motion.h"
#include "scenes/scene.h"

namespace gnomon::gpu {

// A camera that looks along its own -Z, and the tangents of the four half-angles of the traced frustum, which has no
// far plane.
struct CameraView {
  glm::vec3 position{0.0f};
  glm::quat orientation{1.0f, 0.0f, 0.0f, 0.0f};  // camera to world
  float tan_left = 1, tan_right = 1, tan_up = 1, tan_down = 1;
  float near_plane = 0.05f;
};

// For whom a scene was loaded, such as one of the daemon's tenants. 0: nobody in particular.
using SceneOwner = StrongId<struct SceneOwnerTag, uint32_t>;

// A set of a scene's lights, by number.
inline constexpr uint32_t kMaxLights = 256;
using LightSet = std::bitset<kMaxLights>;

struct RenderJob {
  JobId id;
  SceneId scene;  // made resident before
  CameraView camera;
  uint32_t width = 0;  // pixels of the traced buffer
  uint32_t height = 0;
  scenes::SceneTime time{};                // time of the scene's animations, within its period
  LightSet untraced = {};                  // lights that are lit everywhere in the mask
  SampleCounts samples = {};               // which planes the mask has (common/light_planes.h)
  std::optional<uint32_t> tile_rows = {};  // rows that this submit traces, from the top; nullopt: all rows
};

// A frame slot's readback memory, held until the lease is dropped. Move-only; any thread may drop it.
class FrameLease {
 public:
  FrameLease() = default;
  FrameLease(PackedMaskView mask, std::function<void()> release) : mask_(mask), release_(std::move(release)) {}
  FrameLease(FrameLease&& other) noexcept { *this = std::move(other); }
  FrameLease& operator=(FrameLease&& other) noexcept {
    if (this != &other) {
      drop();
      mask_ = other.mask_;
      release_ = std::exchange(other.release_, nullptr);
    }
    return *this;
  }
  ~FrameLease() { drop(); }

  const PackedMaskView& mask() const { return mask_; }  // valid until dropped
  void drop() {
    if (auto release = std::exchange(release_, nullptr)) release();
  }

 private:
  PackedMaskView mask_;
  std::function<void()> release_;
};

// A resident scene's lights by the structure that traces them. All masks are exact; resting lights are the fastest.
struct LightState {
  uint32_t resting = 0;  // traced by what the tracer built for them
  uint32_t moving = 0;   // traced by a hierarchy, because they are not where the tracer built for them
  uint32_t unbuilt = 0;  // traced by a hierarchy, because the tracer's build for the new scene has not ended
};

// The progress of a build beside the frames: for each light the share that is done, 0 to 1; empty if no build runs.
struct BuildProgress {
  std::vector<float> lights;
};

// A renderer's device and methods; constant during its lifetime.
struct DeviceInfo {
  std::string name, driver;
  std::string tracer, raster = {};  // in use
  std::string pci_address = {};     // "0000:65:00.0"; empty if the device is on no such bus
  bool on_cpu = false;              // the device is the host's processor
  // What a scene's light buffers may take if that is more than its number of lights asks for (light_buffer_room).
  uint64_t light_buffer_room = 0;
};

// The device time of one pass of a frame, by the device's timestamps. It is for benchmarks and tests; the daemon uses
// the sums.
struct StageTime {
  std::string_view pass;  // lives as long as the program
  uint64_t gpu_ns = 0;
};

// The memory and build time of a resident scene.
struct SceneFootprint {
  uint64_t memory_bytes = 0;         // on the device, the tracer's included
  uint64_t tracer_memory_bytes = 0;  // of these, the tracer's
  double tracer_build_seconds = 0;
  bool tracer_from_cache = false;  // the light_buffer tracer read its lists from its cache
  double tracer_average_list = 0;  // entries of those lists
  uint32_t tracer_longest_list = 0;
  bool tracer_not_kept = false;  // the cache did not take what the tracer built
};

// A submit that has ended: a complete frame, or a band of one.
struct FrameDone {
  JobId id;
  bool device_lost = false;       // the submit is lost with the device
  bool out_of_memory = false;     // the driver had no memory to start the submit; the device is well
  uint64_t gpu_ns = 0;            // from the submit's first command to its last, by the device's timestamps
  uint64_t frame_gpu_ns = 0;      // gpu_ns summed over the frame's bands up to this one
  uint64_t trace_ns = 0;          // of gpu_ns, the part that grows with the traced bits
  uint64_t readback_ns = 0;       // of gpu_ns, the copy to host memory
  TimePoint completed_at{};       // when the completion thread saw the end of the submit
  std::vector<StageTime> stages;  // every pass, in order
  bool complete = true;           // false: the band is not the frame's last, and there is no lease yet
  FrameLease mask;                // holds the frame's slot; its mask is empty if the submit is lost
};

// An expensive frame may be traced in bands of tile rows: submit rasterises it and traces the first rows (or none),
// each resume traces the next ones, and other frames may be submitted in between. A frame holds its slot until its
// lease is dropped or it is abandoned. All calls: one thread (the render loop's).
//
// A renderer for a real device overrides every function. The default implementations suit the tests' renderers, which
// need no memory, build nothing beside the frames and start each submit at once.
class Renderer {
 public:
  virtual ~Renderer() = default;

  virtual DeviceInfo info() const = 0;
  // How many submits the device runs at the same time; constant.
  virtual uint32_t overlapping() const { return 1; }

  // `freed` is called once for each frame, when free_slots() has grown: its lease was dropped, or it was abandoned and the
  // device has passed its bands. It is called on the thread that dropped the lease, possibly after the renderer's
  // destruction, or on a completion thread. Precondition: nothing was submitted yet.
  virtual void on_slot_freed(std::function<void()> freed) = 0;

  // Uploads a scene and builds what the tracer needs before it can trace; blocking. Idempotent.
  virtual Result<void> make_resident(SceneId id, const scenes::ScenePtr& scene) = 0;
  // As make_resident, on another thread beside the frames, which calls `wake` when finish_background has something to
  // do. `resident` is called once, now or from finish_background. Precondition: the scene is not resident, and no
  // bring() of it is in progress.
  virtual void bring(SceneId id, const scenes::ScenePtr& scene, std::function<void(Result<void>)> resident,
                     std::function<void()> /*wake*/) {
    resident(make_resident(id, scene));
  }
  // Before a scene is brought: whose it is. Work beside the frames is done for several owners at a time, and for each in
  // turn. Forgotten with evict().
  virtual void set_owner(SceneId, SceneOwner) {}
  virtual void evict(SceneId id) = 0;
  // The footprint of a resident scene; zeros if the scene is not resident.
  virtual SceneFootprint footprint(SceneId) const { return {}; }

  // Replaces the lights of a resident scene by as many others; lights that animations move keep moving with them.
  // `changed` is called once, now or from finish_background (then `wake` says when to call that); frames that are
  // submitted later have the new lights. One change of a scene at a time.
  virtual void set_lights(SceneId, std::vector<scenes::Light>, std::function<void(Result<void>)> changed,
                          std::function<void()> /*wake*/) {
    changed(Error{"this renderer's lights cannot be changed"});
  }
  // Repeats the tracer's build for the present places of the lights, beside the frames; `rebuilt` is called from
  // finish_background when frames use the result, or at once if there is nothing to build. Frames are exact before and
  // after, and faster after.
  virtual void rebuild_lights(SceneId, std::function<void(Result<void>)> rebuilt, std::function<void()> /*wake*/) {
    rebuilt({});
  }
  // Takes over the results of work beside the frames, and calls what waits for them.
  virtual void finish_background() {}
  virtual LightState light_state(SceneId) const { return {}; }
  virtual BuildProgress build_progress(SceneId) const { return {}; }  // of rebuild_lights

  // How many frames can be submitted now. Grows when leases are dropped.
  virtual uint32_t free_slots() const = 0;

  // Makes sure that some slot has memory for a frame of this scene, size and time. If no slot is free, it may return
  // success without knowing. Error: out of memory; a smaller frame may succeed.
  virtual Result<void> make_room(const RenderJob&) { return {}; }

  // Starts a frame, or its first band; between begin_batch and end_batch it is recorded, and end_batch starts it.
  // Precondition: free_slots() > 0 and the scene is resident. `on_done` is called
  // once, on the completion thread, also if the device is lost. Error: no memory for a frame of this size; then
  // `on_done` is not called.
  virtual Result<void> submit(const RenderJob& job, std::function<void(FrameDone)> on_done) = 0;

  // Traces the next `tile_rows` of a frame that was submitted with fewer rows than it has; its earlier bands may still
  // be on the device. `on_done` as for submit; the last band delivers the mask. On an error, for example because an
  // earlier band was not started, the frame keeps its slot until it is abandoned.
  virtual Result<void> resume(JobId frame, uint32_t tile_rows, std::function<void(FrameDone)> on_done) = 0;
  // Gives up a frame that was begun but whose last band was not submitted; ignored for other frames. Its slot is free
  // when the device has passed its bands.
  virtual void abandon(JobId frame) = 0;

  // Submits between the two calls are started by end_batch, with one call of the driver for each queue.
  virtual void begin_batch() {}
  virtual void end_batch() {}
};

}  // namespace gnomon::gpu
