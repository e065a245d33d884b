#pragma once

#include "daemon/link/link_sender.h"

namespace gnomon::daemon {

// A session's link over about the last second.
struct LinkReport {
  LinkCounters counted;  // since the last report
  double rate = 0;       // bytes a second that the link may send
  Nanoseconds rtt{};     // smoothed; 0 if not measured
  Nanoseconds queue{};   // queueing on the way to the client
};

}  // namespace gnomon::daemon
