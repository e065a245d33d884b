#include "daemon/net/session_statistics.h"

#include <sstream>

namespace gnomon::daemon {
namespace {

constexpr auto kInterval = std::chrono::seconds(1);

std::string text_of(const std::optional<asio::ip::udp::endpoint>& address) {
  std::ostringstream text;
  if (address) text << *address;
  return text.str();
}

std::string text_of(const ControlStream& stream) { return stream.peer().to_string(); }

}  // namespace

void SessionStatistics::tick(TimePoint now) {
  if (now < next_) return;
  next_ = now + kInterval;
  report();
}

void SessionStatistics::report() {
  std::vector<SessionStatus> all;
  std::array<int, kTransports> by_transport{};
  for (const auto& [id, session] : sessions_.table()) {
    const protocol::Stats stats = session->totals().take_stats();
    shared_.metrics.links().count(session->take_link_report());
    const LinkWindow window = session->views().take_window();
    if (window.offered > 0) shared_.devices.review({id, window});
    ControlStream* const stream = sessions_.stream_of(id);
    if (stream) stream->send(stats);
    const Transport transport = sessions_.transport_of(*session);
    ++by_transport[static_cast<size_t>(transport)];
    const SessionGrant& grant = session->grant();
    const NotifiedShape& now = session->notified_shape();
    all.push_back(
        {.id = id,
         .tenant = grant.tenant,
         .scene = grant.scene_name,
         .transport = transport,
         .address = stream && transport != Transport::udp ? text_of(*stream) : text_of(session->path().current()),
         .width = grant.width,
         .height = grant.height,
         .samples = grant.samples,
         .rate_hz = grant.rate_hz,
         .served = {now.width, now.height, now.samples, now.rate_hz, now.untraced_lights},
         .stats = stats});
  }
  for (size_t i = 0; i < kTransports; ++i) {
    shared_.metrics.links().transports.sessions(static_cast<Transport>(i), by_transport[i] - by_transport_[i]);
  }
  by_transport_ = by_transport;
  published_.publish(std::move(all));
}

}  // namespace gnomon::daemon
