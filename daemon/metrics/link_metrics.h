// The figures of the sessions' links for Prometheus, summed over all sessions to bound the number of series. Part of
// Metrics.
#pragma once

#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include "daemon/metrics/link_report.h"
#include "daemon/metrics/transport_metrics.h"

namespace gnomon::daemon {

// Any thread.
class LinkMetrics {
 public:
  explicit LinkMetrics(prometheus::Registry& registry);

  void count(const LinkReport& report);

  TransportMetrics transports;

 private:
  prometheus::Counter &sent_, &lost_, &retransmitted_, &parity_, &recovered_, &incomplete_;
  prometheus::Histogram &rate_, &rtt_, &queue_;
};

}  // namespace gnomon::daemon
