// Figures of this process, from the system.
#pragma once

namespace gnomon::daemon {

struct ProcessStats {
  double cpu_seconds = 0;         // processor time of all threads since the start
  double start_time_seconds = 0;  // since 1970
  double resident_bytes = 0;
  double virtual_bytes = 0;
  double open_files = 0;
  double max_files = 0;  // the limit of open_files
  double threads = 0;
};

// Any thread. A figure that cannot be read is 0.
ProcessStats process_stats();

}  // namespace gnomon::daemon
