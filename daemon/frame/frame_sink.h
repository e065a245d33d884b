// Where daemon/render and daemon/encode hand on what they have made. Daemon is the only implementation (daemon.cpp), so
// that a reader finds a frame's next stage there.
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
  // A frame is encoded and has to be sent. Called by the encoding threads.
  virtual void on_encoded(EncodedFrame frame) = 0;
  // The client has to be notified of what its session is served from now on. Called by the render threads.
  virtual void on_degraded(const SessionDegraded& session) = 0;
  // Frames use these lights from now on. Called by the render threads, by each for its device.
  virtual void on_lights(const LightsUpdate& lights) = 0;

 protected:
  ~FrameSink() = default;
};

}  // namespace gnomon::daemon
