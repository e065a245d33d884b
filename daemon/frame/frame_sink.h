// Where the results of daemon/render go. Daemon is the only implementation, so that a reader finds the next stage of a
// frame.
#pragma once

#include <string>
#include <vector>

#include "daemon/frame/frame.h"
#include "scenes/scene.h"

namespace gnomon::daemon {

// The lights of a scene as of a version.
struct LightsUpdate {
  std::string scene;
  uint32_t version = 0;
  std::vector<scenes::Light> lights;
};

// Implementations are called from several threads at a time and must not block. The sink outlives all devices.
class FrameSink {
 public:
  // A frame is rendered and has to be encoded. Called by the completion threads of the devices.
  virtual void on_rendered(RenderedFrame frame) = 0;
  // The client has to be notified of what its session is served from now on. Called by the render threads.
  virtual void on_degraded(const SessionDegraded& session) = 0;
  // Frames use these lights from now on. Called by the render threads, by each for its device.
  virtual void on_lights(const LightsUpdate& lights) = 0;

 protected:
  ~FrameSink() = default;
};

}  // namespace gnomon::daemon
