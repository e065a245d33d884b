// Where the render room's results go. The daemon implements it once, so that a reader finds the next stage of a frame.
#pragma once

#include <string>
#include <vector>

#include "daemon/frame/frame.h"
#include "scenes/scene.h"

namespace gnomon::daemon {

// The lights of a scene from a version on.
struct LightsUpdate {
  std::string scene;
  uint32_t version = 0;
  std::vector<scenes::Light> lights;
};

// Implementations are called from several threads at a time and return soon. The sink outlives all devices.
class FrameSink {
 public:
  // A frame is rendered and to be encoded. The completion threads of the devices call this.
  virtual void on_rendered(RenderedFrame frame) = 0;
  // The session's client is to be told what it is served from now on. The render threads call this.
  virtual void on_degraded(const SessionDegraded& session) = 0;
  // Frames are of these lights from now on. The render threads call this, each for its device.
  virtual void on_lights(const LightsUpdate& lights) = 0;

 protected:
  ~FrameSink() = default;
};

}  // namespace gnomon::daemon
