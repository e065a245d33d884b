// The losses of a device: what waits for it to be back, how it is made anew, and when it is given up.
#pragma once

#include <optional>
#include <vector>

#include "daemon/metrics/metrics.h"
#include "daemon/render/render_device.h"
#include "daemon/render/render_inbox.h"
#include "daemon/render/scene_motion.h"

namespace gnomon::daemon {

// The render thread's; told the time.
class DeviceRecovery {
 public:
  DeviceRecovery(RenderDevice& device, SceneMotion& motion, Metrics& metrics)
      : device_(device), motion_(motion), metrics_(metrics) {}

  bool up() const { return !lost_ && !failure_; }
  bool lost() const { return lost_; }                               // until it was made anew
  const std::optional<Error>& failure() const { return failure_; }  // the device is beyond repair

  // Each further loss before the device is made anew is the same one.
  void lose();
  // Precondition: the device is lost. The event is handled when it is back.
  void defer(RenderEvent event) { deferred_.push_back(std::move(event)); }
  // Precondition: the device is lost, and no frame of it is out. Returns what was deferred, to be handled now; nothing if
  // the device is beyond repair: then failure() says why, and whoever waited for a scene was told.
  std::vector<RenderEvent> recover(TimePoint now);

  // The scene does not come to the device after all.
  void forget(SceneId scene);
  // Tells those who wait for a scene that it does not come; forgets the rest.
  void refuse_waiting(const Error& why);

 private:
  RenderDevice& device_;
  SceneMotion& motion_;
  Metrics& metrics_;
  bool lost_ = false;
  std::optional<Error> failure_;
  std::vector<RenderEvent> deferred_;  // scenes and changed lights
};

}  // namespace gnomon::daemon
