#include "daemon/metrics/link_metrics.h"

#include "daemon/metrics/prometheus_families.h"

namespace gnomon::daemon {
namespace {

using prometheus::Counter;
using prometheus::Histogram;

Counter& counter(prometheus::Registry& registry, const char* name, const char* help) {
  return counter_family(registry, name, help).Add({});
}

Histogram& histogram(prometheus::Registry& registry, const char* name, const char* help,
                     const Histogram::BucketBoundaries& buckets) {
  return histogram_family(registry, name, help).Add({}, buckets);
}

const Histogram::BucketBoundaries kRates{125e3, 500e3, 2e6, 8e6};
const Histogram::BucketBoundaries kDelays{0.005, 0.02, 0.1, 0.5};

}  // namespace

LinkMetrics::LinkMetrics(prometheus::Registry& registry)
    : transports(registry),
      sent_(counter(registry, "gnomon_datagrams_sent_total", "Datagrams sent to clients.")),
      lost_(counter(registry, "gnomon_datagrams_lost_total", "Of these, lost by what the clients report.")),
      retransmitted_(counter(registry, "gnomon_datagrams_retransmitted_total", "Datagrams that were sent again.")),
      parity_(counter(registry, "gnomon_datagrams_parity_total", "Datagrams of parity sent.")),
      recovered_(counter(registry, "gnomon_slices_recovered_total", "Slices that clients rebuilt from parity.")),
      incomplete_(
          counter(registry, "gnomon_frames_incomplete_total", "Frames that clients used with tiles missing.")),
      rate_(histogram(registry, "gnomon_link_rate_bytes_per_second",
                      "What a session's link may send, each second of each session.", kRates)),
      rtt_(
          histogram(registry, "gnomon_link_rtt_seconds", "Round-trip time, each second of each session.", kDelays)),
      queue_(histogram(registry, "gnomon_link_queue_seconds",
                       "Waiting in queues on the way to the client, each second of each session.", kDelays)) {}

void LinkMetrics::count(const LinkReport& report) {
  const LinkCounters& counted = report.counted;
  sent_.Increment(static_cast<double>(counted.sent));
  lost_.Increment(static_cast<double>(counted.lost));
  retransmitted_.Increment(static_cast<double>(counted.retransmitted));
  parity_.Increment(static_cast<double>(counted.parity));
  recovered_.Increment(static_cast<double>(counted.recovered));
  incomplete_.Increment(static_cast<double>(counted.incomplete));
  if (report.rtt.count() == 0) return;
  rate_.Observe(report.rate);
  rtt_.Observe(to_seconds(report.rtt));
  queue_.Observe(to_seconds(report.queue));
}

}  // namespace gnomon::daemon
