#include "daemon/link_metrics.h"

namespace gnomon::daemon {
namespace {

using prometheus::Counter;
using prometheus::Family;
using prometheus::Histogram;

Family<Counter>& counter(prometheus::Registry& registry, const char* name, const char* help) {
  return prometheus::BuildCounter().Name(name).Help(help).Register(registry);
}

Family<Histogram>& histogram(prometheus::Registry& registry, const char* name, const char* help) {
  return prometheus::BuildHistogram().Name(name).Help(help).Register(registry);
}

const Histogram::BucketBoundaries kRates{30e3, 60e3, 125e3, 250e3, 500e3, 1e6, 2e6, 4e6, 8e6, 16e6, 64e6, 256e6};
const Histogram::BucketBoundaries kDelays{0.001, 0.002, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1};

}  // namespace

LinkMetrics::LinkMetrics(prometheus::Registry& registry, size_t most_tenants)
    : sent_(counter(registry, "gnomon_datagrams_sent_total", "Datagrams sent to clients.")),
      lost_(counter(registry, "gnomon_datagrams_lost_total", "Of these, lost by what the clients report.")),
      retransmitted_(counter(registry, "gnomon_datagrams_retransmitted_total", "Datagrams that were sent again.")),
      parity_(counter(registry, "gnomon_datagrams_parity_total", "Datagrams of parity sent.")),
      recovered_(counter(registry, "gnomon_slices_recovered_total", "Slices that clients rebuilt from parity.")),
      incomplete_(
          counter(registry, "gnomon_frames_incomplete_total", "Frames that clients used with tiles missing.")),
      rate_(histogram(registry, "gnomon_link_rate_bytes_per_second",
                      "What a session's link may send, each second of each session.")),
      rtt_(histogram(registry, "gnomon_link_rtt_seconds", "Round-trip time, each second of each session.")),
      queue_(histogram(registry, "gnomon_link_queue_seconds",
                       "Waiting in queues on the way to the client, each second of each session.")) {
  tenants_.reserve(most_tenants);
}

void LinkMetrics::add_tenant(const std::string& name) {
  const prometheus::Labels of{{"tenant", name}};
  tenants_.push_back({sent_.Add(of), lost_.Add(of), retransmitted_.Add(of), parity_.Add(of), recovered_.Add(of),
                      incomplete_.Add(of), rate_.Add(of, kRates), rtt_.Add(of, kDelays), queue_.Add(of, kDelays)});
}

void LinkMetrics::count(TenantId tenant, const LinkReport& report) {
  Series& series = tenants_[tenant.value];
  const LinkCounters& counted = report.counted;
  series.sent.Increment(static_cast<double>(counted.sent));
  series.lost.Increment(static_cast<double>(counted.lost));
  series.retransmitted.Increment(static_cast<double>(counted.retransmitted));
  series.parity.Increment(static_cast<double>(counted.parity));
  series.recovered.Increment(static_cast<double>(counted.recovered));
  series.incomplete.Increment(static_cast<double>(counted.incomplete));
  if (report.rtt.count() == 0) return;
  series.rate.Observe(report.rate);
  series.rtt.Observe(to_seconds(report.rtt));
  series.queue.Observe(to_seconds(report.queue));
}

}  // namespace gnomon::daemon
