// What frames of each scene cost on one device, as far as it was learned.
#pragma once

#include "daemon/metrics/status.h"
#include "daemon/render/render_inbox.h"
#include "daemon/render/scene_motion.h"

namespace gnomon::daemon {

// While a hierarchy answers for a scene, its frames cost many times what they will cost later. That is learned apart, and
// what sessions are admitted by does not know it. The render thread's.
class SceneCosts {
 public:
  explicit SceneCosts(const SceneMotion& motion) : motion_(motion) {}

  // The model that frames of the scene follow now.
  scheduler::CostModel& model_of(SceneId scene) { return (motion_.unbuilt(scene) ? unbuilt_ : built_)[scene]; }

  // Precondition: the job was done. True: its scene's model moved by so much at once that it has met something new.
  bool learn(const JobFinished& job);
  void learn_bytes(const BytesSent& sent) { built_[sent.scene].learn_bytes(sent.bits, sent.bytes); }

  // Of scenes for which everything is built.
  const CostModels& built() const { return built_; }

 private:
  const SceneMotion& motion_;
  CostModels built_, unbuilt_;
};

}  // namespace gnomon::daemon
