#pragma once

#include "daemon/link/link_sender.h"

namespace gnomon::daemon {

// A session's link over the last second or so.
struct LinkReport {
  LinkCounters counted;  // since the last report
  double rate = 0;       // bytes a second that it may send
  Nanoseconds rtt{};     // 0: not known
  Nanoseconds queue{};
};

}  // namespace gnomon::daemon
