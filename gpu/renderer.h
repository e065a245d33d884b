// The one GPU seam: views go in, packed tile masks come out. Knows no tenant and no session.
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
#include "scenes/motion.h"
#include "scenes/scene.h"

namespace gnomon::gpu {

// Camera to world; looks along its own -Z. Tangents of the four half-angles of the traced frustum. No far plane.
struct CameraView {
  glm::vec3 position{0.0f};
  glm::quat orientation{1.0f, 0.0f, 0.0f, 0.0f};
  float tan_left = 1, tan_right = 1, tan_up = 1, tan_down = 1;
  float near_plane = 0.05f;
};

// Of a scene's lights, by number.
inline constexpr uint32_t kMaxLights = 256;
using LightSet = std::bitset<kMaxLights>;

struct RenderJob {
  JobId id;
  SceneId scene;  // made resident before
  CameraView camera;
  uint32_t width = 0;  // pixels of the traced buffer
  uint32_t height = 0;
  scenes::SceneTime time{};                // of what moves in the scene, within its period
  LightSet untraced = {};                  // these are lit everywhere in the mask
  std::optional<uint32_t> tile_rows = {};  // what this submit traces, from the top; none: everything
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

// A resident scene's lights by what answers for them. All masks are exact; resting lights are the fastest.
struct LightState {
  uint32_t resting = 0;  // what the tracer built for them
  uint32_t moving = 0;   // a hierarchy, as they are not where the tracer built for
  uint32_t unbuilt = 0;  // a hierarchy, as what the tracer builds for a new scene is not there yet
};

// How far what the tracer builds beside the frames has come: of each light the share that is done, 0 to 1. No lights:
// nothing is being built.
struct BuildProgress {
  std::vector<float> lights;
};

// What a renderer runs on and how; constant as long as it lives.
struct DeviceInfo {
  std::string name, driver;
  std::string tracer, raster = {};  // in use
  std::string pci_address = {};     // "0000:65:00.0"; empty if the device is on no such bus
  bool on_cpu = false;              // the device is the host's processor
};

// What one pass of a frame took, by the device's timestamps. Benchmarks and tests read them; the daemon reads the sums.
struct StageTime {
  std::string_view pass;  // lives as long as the program
  uint64_t gpu_ns = 0;
};

// What a resident scene costs.
struct SceneFootprint {
  uint64_t memory_bytes = 0;         // on the device, the tracer's included
  uint64_t tracer_memory_bytes = 0;  // of these, the tracer's
  double tracer_build_seconds = 0;
  bool tracer_from_cache = false;  // of what the light_buffer tracer built: read from its cache
  double tracer_average_list = 0;  // entries of its lists
  uint32_t tracer_longest_list = 0;
};

// One submit that is done: a whole frame, or a band of one.
struct FrameDone {
  JobId id;
  bool device_lost = false;       // the submit is lost with the device
  bool out_of_memory = false;     // the driver had no memory to start the submit; the device is well
  uint64_t gpu_ns = 0;            // from the submit's first command to its last, by the device's timestamps
  uint64_t frame_gpu_ns = 0;      // the same, summed over the frame's bands up to this one
  uint64_t trace_ns = 0;          // of gpu_ns, the part that grows with the traced bits
  uint64_t readback_ns = 0;       // of gpu_ns, the copy to host memory
  TimePoint completed_at{};       // when the completion thread saw the end of the submit
  std::vector<StageTime> stages;  // every pass, in order
  bool complete = true;           // false: the band is not the frame's last, and there is no lease yet
  FrameLease mask;                // holds the frame's slot; its mask is empty if the submit is lost
};

// A frame that costs much may be traced in bands of tile rows: submit rasterises it and begins with the first ones (or
// with none), resume adds the next, as often as it takes, and others' frames may come between. It holds its slot until
// its lease is dropped or it is abandoned. All calls: one thread (the render loop's).
//
// A renderer for a real device overrides every function. The functions with a body here stand for a renderer that has
// nothing to do there: one that needs no memory, builds nothing beside the frames and starts each submit at once. They
// spare that to the renderers of tests.
class Renderer {
 public:
  virtual ~Renderer() = default;

  virtual DeviceInfo info() const = 0;

  // `freed` is called once for each frame whose last submit was delivered, as soon as its lease was dropped and
  // free_slots() has grown; on the thread that dropped the lease, also after the renderer's end. Frames that were
  // abandoned are not reported. Precondition: nothing was submitted yet.
  virtual void on_slot_freed(std::function<void()> freed) = 0;

  // Uploads a scene and builds what the tracer needs before it can answer; blocking. Idempotent.
  virtual Result<void> make_resident(SceneId id, const scenes::ScenePtr& scene) = 0;
  // The same beside the frames, on another thread, which calls `wake` when finish_background has something to do;
  // `resident` is called once, now or from there. Precondition: not resident, and not on its way already.
  virtual void bring(SceneId id, const scenes::ScenePtr& scene, std::function<void(Result<void>)> resident,
                     std::function<void()> /*wake*/) {
    resident(make_resident(id, scene));
  }
  virtual void evict(SceneId id) = 0;
  // Of a resident scene; zeros for another.
  virtual SceneFootprint footprint(SceneId) const { return {}; }

  // Other lights for a resident scene, as many as before; lights that animations move stay with them. `changed` is
  // called once, now or from finish_background: frames submitted later are of these lights. What answers for a light
  // that moves may have to be built first: beside the frames, on another thread, which calls `wake` when
  // finish_background has something to do. One change of a scene at a time.
  virtual void set_lights(SceneId, std::vector<scenes::Light>, std::function<void(Result<void>)> changed,
                          std::function<void()> /*wake*/) {
    changed(Error{"this renderer's lights cannot be changed"});
  }
  // Builds again what the tracer builds for lights, for where they are now, beside the frames; `rebuilt` is called from
  // finish_background when it serves. Frames are exact before and after; after it they are faster.
  virtual void rebuild_lights(SceneId, std::function<void(Result<void>)> rebuilt, std::function<void()> /*wake*/) {
    rebuilt({});
  }
  virtual void finish_background() {}
  virtual LightState light_state(SceneId) const { return {}; }
  virtual BuildProgress build_progress(SceneId) const { return {}; }  // of rebuild_lights

  // How many submits will be accepted now. Grows when leases are dropped.
  virtual uint32_t free_slots() const = 0;

  // There is memory for a frame of this scene and size, at this time: a slot holds one, or a free one does from now on.
  // Without a free slot nothing is known, which is no error. Error: there is none, a smaller one may pass.
  virtual Result<void> make_room(const RenderJob&) { return {}; }

  // Precondition: free_slots() > 0 and the scene is resident. `on_done` is called once, from the completion thread, also
  // when the device is lost. Error: no memory for a frame of this size; then `on_done` is not called.
  virtual Result<void> submit(const RenderJob& job, std::function<void(FrameDone)> on_done) = 0;

  // The next `tile_rows` of a frame that was begun with fewer than it has; the bands before may still be on the
  // device. `on_done` as above; the mask comes with the last band. On an error, as when a band before was not started,
  // the frame is still begun.
  virtual Result<void> resume(JobId frame, uint32_t tile_rows, std::function<void(FrameDone)> on_done) = 0;
  // Gives a begun frame up. Its slot is free when the bands on the device are done.
  virtual void abandon(JobId frame) = 0;

  // What is submitted between these two starts at the end, with one call of the driver.
  virtual void begin_batch() {}
  virtual void end_batch() {}
};

}  // namespace gnomon::gpu
