// What the sessions' links are like, for Prometheus: of all sessions together, since tenants have only so many series.
// Part of Metrics.
#pragma once

#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include "daemon/metrics/link_report.h"

namespace gnomon::daemon {

// Any thread.
class LinkMetrics {
 public:
  explicit LinkMetrics(prometheus::Registry& registry);

  void count(const LinkReport& report);

 private:
  prometheus::Counter &sent_, &lost_, &retransmitted_, &parity_, &recovered_, &incomplete_;
  prometheus::Histogram &rate_, &rtt_, &queue_;
};

}  // namespace gnomon::daemon
