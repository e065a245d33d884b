#include "daemon/metrics/process_metrics.h"

#include <prometheus/client_metric.h>
#include <prometheus/metric_type.h>

#include <string>

namespace gnomon::daemon {
namespace {

using prometheus::MetricFamily;
using prometheus::MetricType;

MetricFamily family(std::string name, std::string help, MetricType type, double value) {
  prometheus::ClientMetric metric;
  (type == MetricType::Counter ? metric.counter.value : metric.gauge.value) = value;
  return {std::move(name), std::move(help), type, {metric}};
}

MetricFamily gauge(std::string name, std::string help, double value) {
  return family(std::move(name), std::move(help), MetricType::Gauge, value);
}

MetricFamily former(const std::string& name, double value) {
  return gauge("gnomon_" + name, "Deprecated: the same as " + name + ".", value);
}

}  // namespace

std::vector<MetricFamily> process_families(const ProcessStats& figures) {
  return {
      family("process_cpu_seconds_total", "Processor time of the process.", MetricType::Counter,
             figures.cpu_seconds),
      gauge("process_start_time_seconds", "When the process was started, since 1970.", figures.start_time_seconds),
      gauge("process_resident_memory_bytes", "Memory of the process, as the system has it.",
            figures.resident_bytes),
      gauge("process_virtual_memory_bytes", "Address space of the process.", figures.virtual_bytes),
      gauge("process_open_fds", "Open file descriptors.", figures.open_files),
      gauge("process_max_fds", "Most file descriptors that may be open.", figures.max_files),
      gauge("process_threads", "Threads of the process.", figures.threads),
      former("process_resident_memory_bytes", figures.resident_bytes),
      former("process_open_fds", figures.open_files),
      former("process_threads", figures.threads),
  };
}

MetricFamily audit_family(uint64_t unwritten) {
  return family("gnomon_audit_lines_unwritten_total",
                "Lines of the audit log that its file did not take; the daemon's log has them.",
                MetricType::Counter, static_cast<double>(unwritten));
}

MetricFamily log_family(uint64_t unwritten) {
  return family("gnomon_log_lines_unwritten_total",
                "Lines of the log that nobody took from standard error in time.", MetricType::Counter,
                static_cast<double>(unwritten));
}

}  // namespace gnomon::daemon
