#include "daemon/net/net_thread.h"

#include <asio/post.hpp>
#include <future>
#include <sstream>

#include "daemon/frame/translate.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr auto kTick = 50ms;
constexpr auto kStatsInterval = 1s;
constexpr auto kFarewellTime = 100ms;  // for our last words to leave when the server stops
constexpr auto kAnswerTime = 1s;       // for this thread to answer another; beyond it, it has ended
constexpr const char* kTenantClosed = "the tenant is no longer served";
constexpr uint32_t kMaxFramesWaiting = 256;  // encoded, but this thread has not come to send them

}  // namespace

NetThread::NetThread(const NetShared& shared, uint32_t index)
    : shared_(shared),
      index_(index),
      lobby_(std::max(1u, shared.config.server.max_half_open / shared.config.server.net_threads)) {}

Result<std::unique_ptr<NetThread>> NetThread::open(const NetShared& shared, uint32_t index) {
  std::unique_ptr<NetThread> made(new NetThread(shared, index));
  const ServerConfig& server = shared.config.server;
  const auto port = static_cast<uint16_t>(server.data_port == 0 ? 0 : server.data_port + index);
  auto socket = DataSocket::open(made->io_, {asio::ip::make_address(server.listen), port});
  if (!socket) return socket.error();
  made->data_ = std::move(*socket);
  return made;
}

NetThread::~NetThread() { stop(); }

void NetThread::run() {
  data_->start([this](auto datagram, const auto& from) { receive(datagram, from); });
  tick();
  thread_ = std::thread([this] { io_.run(); });
}

void NetThread::stop(bool for_good) {
  if (!thread_.joinable()) return;
  asio::post(io_, [this, for_good] {
    while (sessions_.size() > 0) {
      const SessionId id = sessions_.begin()->first;
      if (for_good || !sessions_.find(id)->resumable()) {
        close_session(id, "the server is stopping");
      } else {
        leave_session(id, "the server is stopping and may come back");
      }
    }
    data_->close();
    stop_when_all_left(Clock::now() + kFarewellTime);
  });
  thread_.join();
}

void NetThread::stop_when_all_left(TimePoint deadline) {
  const TimePoint now = Clock::now();
  lobby_.expire(now);
  if (lobby_.size() == 0 || now >= deadline) return io_.stop();
  timer_.expires_after(1ms);  // in the place of the tick
  timer_.async_wait([this, deadline](asio::error_code) { stop_when_all_left(deadline); });
}

void NetThread::receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from) {
  Metrics& metrics = shared_.metrics;
  metrics.datagram_received();
  if (datagram.size() > protocol::kMaxDatagramBytes) return metrics.report(Fault::datagram_too_long);
  const auto header = protocol::decode_header(datagram);
  if (!header) return metrics.report(Fault::datagram_header);
  Session* session = sessions_.find(header->session);
  if (!session) return metrics.report(Fault::datagram_session);
  const Received received = session->receive(datagram, from, Clock::now());
  if (received.fault) return metrics.report(session->grant().tenant, session->id(), *received.fault);
  if (received.ping) return sender_.answer_ping(*session, *data_, from);
  if (received.view) ask(*session, *received.view);
  serve(*session);
}

void NetThread::deliver(EncodedFrame frame) {
  if (frames_waiting_.fetch_add(1) >= kMaxFramesWaiting) {
    frames_waiting_.fetch_sub(1);
    return shared_.metrics.dropped(frame.meta.route.tenant, frame.meta.route.session, Fault::send_queue_full);
  }
  asio::post(io_, [this, frame = std::move(frame)]() mutable {
    frames_waiting_.fetch_sub(1);
    send(frame);
  });
}

void NetThread::tell(const SessionDegraded& session) {
  asio::post(io_, [this, session] {
    Session* const told = sessions_.find(session.session);
    ControlStream* const stream = stream_of(session.session);
    if (!told || !stream || told->life() != session.life) return;
    stream->send(session.news);
    told->told_of(session.news.width, session.news.height);
  });
}

bool NetThread::kick(SessionId id, const std::string& why) {
  auto answer = std::make_shared<std::promise<bool>>();
  std::future<bool> kicked = answer->get_future();
  asio::post(io_, [this, id, why, answer] {
    answer->set_value(sessions_.find(id) != nullptr);
    close_session(id, why);
  });
  return kicked.wait_for(kAnswerTime) == std::future_status::ready && kicked.get();
}

void NetThread::announce_drain(std::chrono::milliseconds deadline) {
  asio::post(io_, [this, deadline] {
    for (const auto& [id, stream] : streams_) {
      stream->send(protocol::Draining{static_cast<uint32_t>(deadline.count())});
    }
    for (const SessionId id : sessions_.not_resumed(TimePoint::max() - 1ns)) {
      close_session(id, "without a control connection when the server went away");
    }
  });
}

void NetThread::announce_lights(const LightsNews& news) {
  asio::post(io_,
             [this, scene = news.scene, message = protocol::LightsChanged{to_wire(news.lights), news.version}] {
               for (const auto& [id, stream] : streams_) {
                 if (sessions_.find(id)->grant().scene_name == scene) stream->send(message);
               }
             });
}

void NetThread::close_closed_tenants() {
  asio::post(io_, [this] {
    const auto roster = shared_.roster.get();
    std::vector<SessionId> closed;
    for (const auto& [id, session] : sessions_) {
      if (!roster->open(session->grant().tenant)) closed.push_back(id);
    }
    for (const SessionId id : closed) close_session(id, kTenantClosed);
  });
}

void NetThread::tick() {
  const TimePoint now = Clock::now();
  for (const SessionId id : sessions_.silent_since(now - shared_.config.server.silence_timeout)) {
    close_session(id, "silent");
  }
  for (const SessionId id : sessions_.not_resumed(now))
    close_session(id, "its control connection did not come back");
  if (index_ == 0) shared_.store.expire(now);
  for (const Visitor& visitor : lobby_.expire(now)) {
    if (!visitor.leaving) shared_.metrics.report(Fault::handshake_timeout);
    visitor.stream->close();
  }
  if (now >= next_stats_) {
    next_stats_ = now + kStatsInterval;
    report_stats();
  }
  timer_.expires_after(kTick);
  timer_.async_wait([this](asio::error_code error) {
    if (!error) tick();
  });
}

void NetThread::report_stats() {
  std::vector<SessionStatus> all;
  for (const auto& [id, session] : sessions_) {
    const protocol::Stats stats = session->take_stats();
    shared_.metrics.link(session->take_link_report());
    const LinkWindow window = session->take_link_window();
    if (window.offered > 0) shared_.devices.review({id, window});
    if (ControlStream* const stream = stream_of(id)) stream->send(stats);
    std::string address;
    if (session->address()) {
      std::ostringstream text;
      text << *session->address();
      address = text.str();
    }
    const SessionGrant& grant = session->grant();
    all.push_back({.id = id,
                   .tenant = grant.tenant,
                   .scene = grant.scene_name,
                   .address = std::move(address),
                   .width = grant.width,
                   .height = grant.height,
                   .stats = stats});
  }
  published_.publish(std::move(all));
}

}  // namespace gnomon::daemon
