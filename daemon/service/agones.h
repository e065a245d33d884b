// Tells Agones, where it runs the node, what it wants to know of a game server (agones_life.h), through the sidecar that it
// puts beside it. Sessions come through the fleet's door all the same: Agones only starts, watches and replaces nodes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "common/clock.h"

namespace gnomon::daemon {

// Has a thread of its own, so that signs of life go on while the main thread loads scenes or waits for sessions to end.
class Agones {
 public:
  // Of AGONES_SDK_HTTP_PORT, which Agones sets; its usual one where the text is nullptr or no port.
  static uint16_t port_of(const char* text);

  explicit Agones(uint16_t port);  // on loopback
  ~Agones();                       // without a word, if leave() was not called

  // Any thread.
  void ready();
  // The devices have been found to work. If that was once said, and then not for kHung, signs of life end.
  void alive(TimePoint at);
  static constexpr std::chrono::seconds kHung{10};  // as long as WatchdogSec in the systemd unit

  // Blocks until the sidecar has taken it, or for some seconds. Called once.
  void leave();

 private:
  struct Talk;
  std::unique_ptr<Talk> talk_;
};

}  // namespace gnomon::daemon
