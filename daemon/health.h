// What the daemon as a whole is doing: written by main and the render thread, read by everybody.
#pragma once

#include <atomic>

namespace gnomon::daemon {

struct Health {
  std::atomic<bool> scenes_loaded{false};
  std::atomic<bool> device_up{false};
  std::atomic<bool> draining{false};

  bool ready() const { return scenes_loaded && device_up && !draining; }
};

}  // namespace gnomon::daemon
