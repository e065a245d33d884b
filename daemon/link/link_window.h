// How many of a session's views its link had room for.
#pragma once

#include <cstdint>

namespace gnomon::daemon {

// Counts of a session's views at its link, over about a second.
struct LinkWindow {
  uint32_t offered = 0;  // views that arrived
  uint32_t taken = 0;    // views that the link had room for
};

}  // namespace gnomon::daemon
