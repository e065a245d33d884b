// The process's figures under the names that Prometheus's client libraries agree on, for which dashboards exist.
#pragma once

#include <prometheus/metric_family.h>

#include <cstdint>
#include <vector>

#include "daemon/metrics/process_stats.h"

namespace gnomon::daemon {

// Also under the names gnomon_process_* of earlier versions.
std::vector<prometheus::MetricFamily> process_families(const ProcessStats& figures);

// Of the audit log, which is written beside everything else; `unwritten`: lines since the start.
prometheus::MetricFamily audit_family(uint64_t unwritten);
prometheus::MetricFamily log_family(uint64_t unwritten);

}  // namespace gnomon::daemon
