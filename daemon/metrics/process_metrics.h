// The process's figures under the names that Prometheus's client libraries agree on, for which dashboards exist.
#pragma once

#include <prometheus/metric_family.h>

#include <vector>

#include "daemon/metrics/process_stats.h"

namespace gnomon::daemon {

// Also under the names gnomon_process_* of earlier versions.
std::vector<prometheus::MetricFamily> process_families(const ProcessStats& figures);

}  // namespace gnomon::daemon
