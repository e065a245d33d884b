// What a link reports about the views that it took.
#pragma once

#include <cstdint>

namespace gnomon::daemon {

// What happened to a session's views at its link in about a second.
struct LinkWindow {
  uint32_t offered = 0;  // views that came
  uint32_t taken = 0;    // of them, those that the link had room for
};

}  // namespace gnomon::daemon
