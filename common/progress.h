// Shows a program's progress: one line that is rewritten on a terminal, plain lines every few seconds elsewhere. One
// thread.
#pragma once

#include <cstdio>
#include <string>

#include "common/clock.h"

namespace gnomon {

class Progress {
 public:
  explicit Progress(std::FILE* out = stderr);
  ~Progress();  // clears the live line

  // True if a line for show() is due.
  bool due(TimePoint now) const { return now >= next_; }
  void show(const std::string& line, TimePoint now);
  // Clears the live line, so that other output starts on a fresh one.
  void clear();

 private:
  std::FILE* out_;
  bool terminal_;
  bool shown_ = false;
  TimePoint next_{};
};

}  // namespace gnomon
