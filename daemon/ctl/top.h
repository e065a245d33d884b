// The live table of `gnomonctl top`.
#pragma once

#include <chrono>
#include <cstdint>

#include "daemon/ctl/admin_client.h"

namespace gnomon::ctl {

struct TopOptions {
  std::chrono::milliseconds interval{1000};
  uint32_t count = 0;  // tables before it ends; 0: until it is interrupted
  bool json = false;   // one object a line instead
};

// Draws on a terminal in place, else one table after the other. Error: the daemon has gone.
Result<void> top(AdminClient& admin, const TopOptions& options);

}  // namespace gnomon::ctl
