// The live table of `gnomonctl top`.
#pragma once

#include <chrono>
#include <cstdint>

#include "daemon/ctl/admin_client.h"

namespace gnomon::ctl {

struct TopOptions {
  std::chrono::milliseconds interval{1000};
  uint32_t count = 0;  // number of tables; 0: until it is left or interrupted
  bool json = false;   // prints one object a line instead
};

// On a terminal a screen that its user sorts, filters and scrolls; else one table after the other. Blocks. Error if the
// daemon does not answer; on a terminal, if it does not answer at first.
Result<void> top(AdminClient& admin, const TopOptions& options);

}  // namespace gnomon::ctl
