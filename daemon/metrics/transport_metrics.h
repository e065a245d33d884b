// What goes over which transport, and what browsers ask for over HTTP, for Prometheus. Part of LinkMetrics.
#pragma once

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/registry.h>

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>

namespace gnomon::daemon {

// How frames reach a client: datagrams, or its control connection, plain or in a browser; or a browser's
// datagrams.
enum class Transport : uint8_t { udp, tcp, websocket, webtransport };
inline constexpr size_t kTransports = 4;
const char* to_string(Transport transport);

// Any thread. Series are made when there is something to count, as most daemons serve no browsers.
class TransportMetrics {
 public:
  explicit TransportMetrics(prometheus::Registry& registry);

  void sessions(Transport transport, int change);  // so many more are open
  void sent(Transport transport, size_t bytes);
  void answered(int status);  // an HTTP request of a browser

 private:
  static constexpr size_t kClasses = 5;  // 1xx to 5xx

  prometheus::Family<prometheus::Gauge>& open_;
  prometheus::Family<prometheus::Counter>&bytes_, &requests_;
  std::array<std::atomic<prometheus::Gauge*>, kTransports> open_by_{};
  std::array<std::atomic<prometheus::Counter*>, kTransports> bytes_by_{};
  std::array<std::atomic<prometheus::Counter*>, kClasses> requests_by_{};
};

}  // namespace gnomon::daemon
