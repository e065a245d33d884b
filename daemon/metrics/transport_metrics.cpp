#include "daemon/metrics/transport_metrics.h"

#include <algorithm>
#include <string>

#include "daemon/metrics/prometheus_families.h"

namespace gnomon::daemon {
namespace {

// The family returns the same series to whoever asks twice.
template <class Series>
Series& series(std::atomic<Series*>& kept, prometheus::Family<Series>& family, const char* label,
               const std::string& value) {
  Series* found = kept;
  if (!found) kept = found = &family.Add({{label, value}});
  return *found;
}

}  // namespace

const char* to_string(Transport transport) {
  switch (transport) {
    case Transport::udp: return "udp";
    case Transport::tcp: return "tcp";
    case Transport::websocket: return "websocket";
    case Transport::webtransport: return "webtransport";
  }
  return "";
}

TransportMetrics::TransportMetrics(prometheus::Registry& registry)
    : open_(
          gauge_family(registry, "gnomon_transport_sessions", "Open sessions, by how frames reach their clients.")),
      bytes_(counter_family(registry, "gnomon_transport_bytes_sent_total",
                            "Bytes of frames sent to clients, by how they reach them.")),
      requests_(counter_family(registry, "gnomon_web_requests_total",
                               "HTTP requests of browsers that were answered, by class of the answer.")) {}

void TransportMetrics::sessions(Transport transport, int change) {
  auto& kept = open_by_[static_cast<size_t>(transport)];
  if (change != 0) series(kept, open_, "transport", to_string(transport)).Increment(change);
}

void TransportMetrics::sent(Transport transport, size_t bytes) {
  auto& kept = bytes_by_[static_cast<size_t>(transport)];
  series(kept, bytes_, "transport", to_string(transport)).Increment(static_cast<double>(bytes));
}

void TransportMetrics::answered(int status) {
  const int first = std::clamp(status / 100, 1, static_cast<int>(kClasses));
  auto& kept = requests_by_[static_cast<size_t>(first - 1)];
  series(kept, requests_, "class", std::to_string(first) + "xx").Increment();
}

}  // namespace gnomon::daemon
