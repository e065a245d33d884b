// Figures of this process from /proc.
#pragma once

namespace gnomon::daemon {

struct ProcessFigures {
  double resident_bytes = 0;
  double open_files = 0;
  double threads = 0;
};

// Any thread. A figure that cannot be read is 0.
ProcessFigures process_figures();

}  // namespace gnomon::daemon
