// What a door is told of this node, so that it knows whether to send clients here: a line of HAProxy's agent protocol.
// https://docs.haproxy.org/2.6/configuration.html, "agent-check". Pure.
#pragma once

#include <string_view>

namespace gnomon::daemon {

// One thread at a time.
class DoorSign {
 public:
  // `admits`: new sessions are let in. `load`: what is booked of the devices in service; 1 is all of them. The line ends
  // with a newline; `ready` in it takes back an earlier `drain`.
  //
  // A node that is full asks for next to nothing rather than for nothing: when all are full, admission and degradation
  // decide who is served what, and not a door that has nobody left to choose.
  std::string_view line(bool admits, double load);

  // A node is full from the former on and until its load is below the latter. Between them it stays what it was, so that
  // scenes do not go back and forth with every session.
  static constexpr double kFull = 0.85;
  static constexpr double kHasRoom = 0.75;

 private:
  bool full_ = false;
};

inline std::string_view DoorSign::line(bool admits, double load) {
  if (load >= kFull) full_ = true;
  if (load < kHasRoom) full_ = false;
  if (!admits) return "drain\n";
  return full_ ? "ready up 1%\n" : "ready up 100%\n";
}

}  // namespace gnomon::daemon
