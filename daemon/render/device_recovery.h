// Recovery from the loss of a device: the events that wait for it, its rebuild, and when it is given up.
#pragma once

#include <optional>
#include <vector>

#include "daemon/metrics/metrics.h"
#include "daemon/render/render_device.h"
#include "daemon/render/render_inbox.h"
#include "daemon/render/scene_motion.h"

namespace gnomon::daemon {

// Belongs to the render thread; the caller passes the time.
class DeviceRecovery {
 public:
  DeviceRecovery(RenderDevice& device, SceneMotion& motion, Metrics& metrics)
      : device_(device), motion_(motion), metrics_(metrics) {}

  bool up() const { return !lost_ && !failure_; }
  bool lost() const { return lost_; }                               // until recover() has succeeded
  const std::optional<Error>& failure() const { return failure_; }  // the device is beyond repair

  // The device was lost. Further calls before it is rebuilt have no effect.
  void lose();
  // Keeps the event until the device is rebuilt. Precondition: the device is lost.
  void defer(RenderEvent event) { deferred_.push_back(std::move(event)); }
  // Rebuilds the device; blocking. Returns the deferred events, to be handled now. If the device is beyond repair,
  // returns nothing: failure() says why, and deferred scenes were answered with that error. Precondition: the device is
  // lost, and no frame of it is out.
  std::vector<RenderEvent> recover(TimePoint now);

  // Drops the deferred arrival of the scene, which is not brought to the device after all.
  void forget(SceneId scene);
  // Answers everything that waits for a scene with the error; drops the other deferred events.
  void refuse_waiting(const Error& why);

 private:
  RenderDevice& device_;
  SceneMotion& motion_;
  Metrics& metrics_;
  bool lost_ = false;
  std::optional<Error> failure_;
  std::vector<RenderEvent> deferred_;  // arriving scenes and changes of lights
};

}  // namespace gnomon::daemon
