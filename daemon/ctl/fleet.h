// Makes the configuration of a fleet's door: HAProxy in front of the nodes named. Needs no running daemon.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"

namespace gnomon::ctl {

struct DoorRequest {
  std::vector<std::string> nodes;  // "NAME=HOST" or "NAME=HOST:PORT" of each one's control port
  std::string listen = ":7600";    // where clients come, as HAProxy's bind has it
  uint16_t door_port = 7602;       // the nodes' fleet.door_port
  uint32_t max_connections = 20'000;
};

// The text of haproxy.cfg. Error: which node is named wrongly.
//
// What a node is called decides which scenes it gets: the doors of a fleet have the same names for the same nodes, and a
// node that comes or goes moves no scenes but its own.
Result<std::string> haproxy_text(const DoorRequest& request);

}  // namespace gnomon::ctl
