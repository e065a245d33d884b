// Figures of this process from /proc.
#pragma once

namespace gnomon::daemon {

struct ProcessStats {
  double resident_bytes = 0;
  double open_files = 0;
  double threads = 0;
};

// Any thread. A figure that cannot be read is 0.
ProcessStats process_stats();

}  // namespace gnomon::daemon
