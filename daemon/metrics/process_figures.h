// What the system says about this process.
#pragma once

namespace gnomon::daemon {

struct ProcessFigures {
  double resident_bytes = 0;
  double open_files = 0;
  double threads = 0;
};

// Any thread. 0 for what the system does not say.
ProcessFigures process_figures();

}  // namespace gnomon::daemon
