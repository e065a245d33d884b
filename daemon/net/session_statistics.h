// What the sessions of a net thread did lately: once a second each client is told of its own, operators may look at all
// of them, the links' figures go to the metrics, and devices learn which links could not carry more.
#pragma once

#include <memory>
#include <vector>

#include "daemon/metrics/status.h"
#include "daemon/net/net_shared.h"
#include "daemon/net/open_sessions.h"

namespace gnomon::daemon {

// The net thread's, but latest(). Outlived by what it refers to.
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
  Published<std::vector<SessionStatus>> published_;
};

}  // namespace gnomon::daemon
