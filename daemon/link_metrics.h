// What the sessions' links are like, for Prometheus: by tenant, never by session. Part of Metrics.
#pragma once

#include <prometheus/counter.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>

#include <string>
#include <vector>

#include "common/ids.h"
#include "daemon/link_report.h"

namespace gnomon::daemon {

// Any thread may count for tenants that are known; they are made known one after the other, before.
class LinkMetrics {
 public:
  LinkMetrics(prometheus::Registry& registry, size_t most_tenants);

  void add_tenant(const std::string& name);
  void count(TenantId tenant, const LinkReport& report);

 private:
  struct Series {
    prometheus::Counter &sent, &lost, &retransmitted, &parity, &recovered, &incomplete;
    prometheus::Histogram &rate, &rtt, &queue;
  };

  prometheus::Family<prometheus::Counter>&sent_, &lost_, &retransmitted_, &parity_, &recovered_, &incomplete_;
  prometheus::Family<prometheus::Histogram>&rate_, &rtt_, &queue_;
  std::vector<Series> tenants_;  // reserved once: growing moves nothing
};

}  // namespace gnomon::daemon
