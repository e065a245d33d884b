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

}  // namespace

void SessionStatistics::tick(TimePoint now) {
  if (now < next_) return;
  next_ = now + kInterval;
  report();
}

void SessionStatistics::report() {
  std::vector<SessionStatus> all;
  for (const auto& [id, session] : sessions_.table()) {
    const protocol::Stats stats = session->totals().take_stats();
    shared_.metrics.link(session->take_link_report());
    const LinkWindow window = session->views().take_window();
    if (window.offered > 0) shared_.devices.review({id, window});
    if (ControlStream* const stream = sessions_.stream_of(id)) stream->send(stats);
    const SessionGrant& grant = session->grant();
    all.push_back({.id = id,
                   .tenant = grant.tenant,
                   .scene = grant.scene_name,
                   .address = text_of(session->path().current()),
                   .width = grant.width,
                   .height = grant.height,
                   .stats = stats});
  }
  published_.publish(std::move(all));
}

}  // namespace gnomon::daemon
