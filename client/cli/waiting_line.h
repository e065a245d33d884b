// Shows what a client waits for before its session is open, as the server tells it.
#pragma once

#include <string>

#include "common/progress.h"
#include "protocol/messages.h"

namespace gnomon::client {

// One line for a person, such as "the scene is being read, 40%".
std::string describe(const protocol::Waiting& waiting);

// Belongs to one thread.
class WaitingLine {
 public:
  // `server`: as the user named it. `progress` outlives this.
  WaitingLine(Progress& progress, std::string server);

  // Any message; those that are no Waiting are passed over. What is waited for is shown at once, and its duration as
  // often as the progress is due.
  void heard(const protocol::Message& message);

 private:
  Progress& progress_;
  const std::string server_;
  const TimePoint since_ = Clock::now();
  std::string shown_;
};

}  // namespace gnomon::client
