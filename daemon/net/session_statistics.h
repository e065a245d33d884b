// The statistics of a net thread's sessions. Once a second each client is sent its own, all are published for
// operators, the links' figures are added to the metrics, and the devices learn how many views each link had room for.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "daemon/metrics/status.h"
#include "daemon/net/net_shared.h"
#include "daemon/net/open_sessions.h"

namespace gnomon::daemon {

// Belongs to the net thread, except latest(). Outlived by everything it refers to.
class SessionStatistics {
 public:
  SessionStatistics(const NetShared& shared, const OpenSessions& sessions) : shared_(shared), sessions_(sessions) {}

  void tick(TimePoint now);  // reports if a second has passed since the last report

  std::shared_ptr<const std::vector<SessionStatus>> latest() const { return published_.get(); }  // any thread

 private:
  void report();

  const NetShared& shared_;
  const OpenSessions& sessions_;
  TimePoint next_{};
  std::array<int, kTransports> by_transport_{};  // sessions, at the last report
  Published<std::vector<SessionStatus>> published_;
};

}  // namespace gnomon::daemon
