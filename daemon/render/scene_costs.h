// Learned models of what frames of each scene cost on one device.
#pragma once

#include "daemon/metrics/status.h"
#include "daemon/render/render_inbox.h"
#include "daemon/render/scene_motion.h"

namespace gnomon::daemon {

// While a scene's lights are traced with a hierarchy, as its light buffers are not built yet, its frames cost many
// times what they will cost later. These costs are learned in a separate model, which admission does not use. Belongs
// to the render thread.
class SceneCosts {
 public:
  SceneCosts(const SceneMotion& motion, bool on_cpu)
      : motion_(motion), most_soft_bits_(on_cpu ? kMostSoftBitsOfCpu : kMostSoftBitsOfGpu) {}

  // The model that applies to frames of the scene now.
  const scheduler::CostModel& model_of(SceneId scene, SampleCounts samples) {
    return (motion_.unbuilt(scene) ? unbuilt_ : built_)[scene].model(samples);
  }

  // So many bits of a frame of the scene are traced within `limit`, whatever its view.
  uint64_t bits_within(SceneId scene, SampleCounts samples, Nanoseconds limit) {
    return (motion_.unbuilt(scene) ? unbuilt_ : built_)[scene].bits_within(samples, limit, most_soft_bits_);
  }

  // Precondition: the job was executed. `quantum`: what no job should take; 0: whatever it likes. Returns true if the
  // scene's model changed by more than a quarter at once.
  bool learn(const JobFinished& job, Nanoseconds quantum);
  void learn_bytes(const BytesSent& sent) {
    built_[sent.scene].of(sent.samples).learn_bytes(sent.bits, sent.bytes);
  }

  // The models of frames whose scene has all its light buffers.
  const CostModels& built() const { return built_; }

 private:
  // What takes about a quantum where every point needs a walk of its own.
  static constexpr uint64_t kMostSoftBitsOfCpu = 1 << 18, kMostSoftBitsOfGpu = 1 << 22;

  const SceneMotion& motion_;
  const uint64_t most_soft_bits_;
  CostModels built_, unbuilt_;
};

}  // namespace gnomon::daemon
