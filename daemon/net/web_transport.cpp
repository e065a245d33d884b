#include "daemon/net/web_transport.h"

#include <algorithm>
#include <array>
#include <cstring>

#include "common/log.h"
#include "common/within_memory.h"
#include "daemon/net/tls_identity.h"
#include "daemon/security/random_bytes.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

// Browsers take a certificate by its hash if it lasts no more than two weeks. One is replaced when half of its time is
// over, so that a page that was told of the one before still gets in where clocks differ.
constexpr auto kCertificateLasts = 10 * 24h;
constexpr auto kRenewAfter = kCertificateLasts / 2;
constexpr const char* kPath = "/session?ticket=";
constexpr size_t kHeadBytes = 9;  // kind and sequence
static_assert(kHeadBytes + LinkSender::kMostWebTransportBody <= quic::kMostDatagramBytes);

quic::Address address_of(const asio::ip::udp::endpoint& endpoint) {
  quic::Address address;
  address.size = static_cast<uint32_t>(std::min(endpoint.size(), address.bytes.size()));
  std::memcpy(address.bytes.data(), endpoint.data(), address.size);
  return address;
}

asio::ip::udp::endpoint endpoint_of(const quic::Address& address) {
  asio::ip::udp::endpoint endpoint;
  std::memcpy(endpoint.data(), address.bytes.data(), std::min<size_t>(address.size, endpoint.capacity()));
  endpoint.resize(address.size);
  return endpoint;
}

std::string new_ticket() {
  std::string ticket;
  for (int word = 0; word < 2; ++word) {
    const uint64_t bits = random_number();
    for (int shift = 60; shift >= 0; shift -= 4) ticket += "0123456789abcdef"[bits >> shift & 15];
  }
  return ticket;
}

template <class T>
T load(std::span<const uint8_t> bytes) {
  T value;
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

}  // namespace

Result<void> WebTransport::open(DataSocket& socket) {
  if (!shared_.config.web.webtransport) return {};
  auto identity = next_identity(Clock::now());
  if (!identity) return identity.error();
  const ServerConfig& server = shared_.config.server;
  quic::Options options{.identity = std::move(*identity), .local = address_of(socket.local()), .limits = {}};
  options.limits.patience = server.handshake_timeout;
  options.limits.silence = server.silence_timeout;
  options.limits.half_open = std::max(1u, server.max_half_open / server.net_threads);
  options.limits.retry_above = std::max<size_t>(1, options.limits.half_open / 4);
  options.limits.per_network = server.max_sessions_per_address;
  options.limits.per_network_per_s = server.connections_per_s;
  auto made = quic::make_endpoint(options);
  if (!made) return Error{"web.webtransport: " + made.error().message};
  endpoint_ = std::move(*made);
  socket_ = &socket;
  return {};
}

// The server's own certificate, where browsers trust it; else a new one, which they know by its hash.
Result<Identity> WebTransport::next_identity(TimePoint now) {
  const std::shared_ptr<Tls> tls = *shared_.tls.get();
  tls_ = tls;
  hashes_.clear();
  renew_at_ = TimePoint::max();
  if (auto trusted = trusted_identity(tls->context)) return std::move(*trusted);
  std::vector<std::string> hosts = tls->names;
  if (hosts.empty()) hosts.push_back("localhost");
  auto made = make_certificate(
      {.name = "gnomon", .hosts = std::move(hosts), .lasts = std::chrono::seconds(kCertificateLasts)});
  if (!made) return made.error();
  const auto pin = pin_of_pem(made->certificate);
  if (!pin) return pin.error();
  hashes_.push_back(*pin);
  renew_at_ = now + kRenewAfter;
  return made;
}

void WebTransport::review(TimePoint now) {
  if (!endpoint_ || (now < renew_at_ && *shared_.tls.get() == tls_)) return;
  const auto before = hashes_;
  const auto identity = next_identity(now);
  const auto used = identity ? endpoint_->set_identity(*identity) : Result<void>(identity.error());
  if (!used) {
    hashes_ = before;
    renew_at_ = now + 1h;
    return log::error("no new certificate for WebTransport", {{"why", used.error().message}});
  }
  for (const auto& [id, stream] : sessions_.streams()) offer(*sessions_.find(id));
}

void WebTransport::offer(const Session& session) {
  ControlStream* const stream = sessions_.stream_of(session.id());
  const bool asks =
      endpoint_ && stream && stream->is_browser() && session.grant().has(protocol::kFeatureWebTransport);
  if (!asks) return;
  Link& link = links_[session.id()];
  link.ticket = new_ticket();
  stream->send(protocol::WebTransport{socket_->port(), link.ticket, hashes_});
}

void WebTransport::drop(SessionId id) {
  const auto found = links_.find(id);
  if (found == links_.end()) return;
  const auto connection = found->second.connection;
  links_.erase(found);
  if (!connection) return;
  const TimePoint now = Clock::now();
  owners_.erase(*connection);
  endpoint_->close(*connection, now);
  flush(now);
}

void WebTransport::close() {
  while (!owners_.empty()) drop(SessionId(owners_.begin()->second));
  endpoint_.reset();
  timer_.cancel();
}

bool WebTransport::receive(std::span<const uint8_t> datagram, const asio::ip::udp::endpoint& from) {
  if (!endpoint_ || !quic::is_quic(datagram)) return false;
  const TimePoint now = Clock::now();
  endpoint_->receive(datagram, address_of(from), now);
  handle_events(now);
  return true;
}

// What the events lead to may send, and so make further ones.
void WebTransport::handle_events(TimePoint now) {
  struct Handling {
    explicit Handling(bool& flag) : flag_(flag) { flag_ = true; }
    ~Handling() { flag_ = false; }
    bool& flag_;
  };
  std::optional<Handling> handling(handling_);
  for (auto events = endpoint_->take_events(); !events.empty(); events = endpoint_->take_events()) {
    for (const quic::Event& event : events) {
      if (const auto* asked = std::get_if<quic::SessionAsked>(&event.what)) admit(event.connection, *asked, now);
      if (const auto* datagram = std::get_if<quic::Datagram>(&event.what)) {
        on_datagram(event.connection, datagram->bytes);
      }
      if (const auto* outcome = std::get_if<quic::Outcome>(&event.what))
        on_outcome(event.connection, *outcome, now);
      if (std::holds_alternative<quic::Closed>(event.what)) on_closed(event.connection);
      if (std::holds_alternative<quic::Room>(event.what)) {
        if (Session* const session = session_of(event.connection)) listener_.serve(*session);
      }
    }
  }
  handling.reset();
  flush(now);
}

// A page of the origin that opened the session, with the ticket that only it was told.
std::optional<SessionId> WebTransport::owner_of(const quic::SessionAsked& asked) const {
  if (!asked.path.starts_with(kPath)) return std::nullopt;
  const std::string ticket = asked.path.substr(std::strlen(kPath));
  if (ticket.empty()) return std::nullopt;
  for (const auto& [id, link] : links_) {
    ControlStream* const stream = sessions_.stream_of(id);
    if (link.ticket == ticket && stream && stream->origin() == asked.origin) return id;
  }
  return std::nullopt;
}

void WebTransport::admit(quic::ConnectionId id, const quic::SessionAsked& asked, TimePoint now) {
  const auto owner = owner_of(asked);
  if (!owner) {
    shared_.metrics.report(Fault::webtransport_ticket);
    return endpoint_->refuse(id, 403, now);
  }
  Link& link = links_.at(*owner);
  if (const auto before = std::exchange(link.connection, id)) {
    owners_.erase(*before);
    endpoint_->close(*before, now);
  }
  owners_.emplace(id, *owner);
  endpoint_->accept(id, now);
  offer(*sessions_.find(*owner));  // another ticket, as each opens one connection
}

Session* WebTransport::session_of(quic::ConnectionId id) const {
  const auto owner = owners_.find(id);
  return owner == owners_.end() ? nullptr : sessions_.find(owner->second);
}

void WebTransport::on_datagram(quic::ConnectionId id, std::span<const uint8_t> bytes) {
  Session* const session = session_of(id);
  if (!session || bytes.size() < kHeadBytes) return;
  shared_.metrics.datagram_received();
  const auto body = bytes.subspan(kHeadBytes);
  listener_.data(*session, {static_cast<protocol::DatagramKind>(bytes[0]),
                            load<uint64_t>(bytes.subspan(1)),
                            {body.begin(), body.end()}});
}

void WebTransport::on_outcome(quic::ConnectionId id, const quic::Outcome& outcome, TimePoint now) {
  Session* const session = session_of(id);
  if (!session) return;
  session->link().on_outcome(outcome.number, outcome.arrived, now);
  if (!outcome.arrived) listener_.serve(*session);
}

// What waits goes over the WebSocket, where the next camera is to be expected.
void WebTransport::on_closed(quic::ConnectionId id) {
  Session* const session = session_of(id);
  owners_.erase(id);
  if (!session) return;
  links_.at(session->id()).connection.reset();
  if (session->way() == Way::web_transport) session->way() = Way::control;
  listener_.serve(*session);
}

bool WebTransport::send(Session& session, TimePoint now) {
  Link& link = links_.at(session.id());
  LinkSender& sender = session.link();
  bool has_room = true;
  while (has_room) {
    const auto out = sender.next(now);
    if (!out) break;
    // A number that the endpoint had no room for is not spent: the next datagram has it.
    if (link.unused == 0) link.unused = session.seal().skip();
    std::array<uint8_t, kHeadBytes> head;
    head[0] = static_cast<uint8_t>(out->kind);
    std::memcpy(head.data() + 1, &link.unused, sizeof link.unused);
    has_room = endpoint_->send(*link.connection, link.unused, head, out->body, now);
    if (has_room) sender.sent(std::exchange(link.unused, 0), protocol::Seal::sealed_size(out->body.size()), now);
  }
  if (!handling_) flush(now);
  return has_room;
}

void WebTransport::flush(TimePoint now) {
  std::vector<quic::Packet> packets = endpoint_->take_packets(now);
  std::vector<std::vector<uint8_t>> batch;
  for (size_t i = 0; i < packets.size();) {
    batch.clear();
    const quic::Address& to = packets[i].to;
    size_t end = i;
    while (end < packets.size() && packets[end].to == to) batch.push_back(std::move(packets[end++].bytes));
    asio::error_code ignored;  // what the kernel does not take is lost, as on the network
    socket_->send(batch, endpoint_of(to), ignored);
    i = end;
  }
  arm_timer();
}

void WebTransport::arm_timer() {
  const TimePoint next = endpoint_->wake_at();
  if (next >= armed_) return;
  armed_ = next;
  until_memory_suffices([&] {
    timer_.expires_at(next);
    timer_.async_wait([this](const asio::error_code& error) {
      if (error || !endpoint_) return;  // another one was armed
      armed_ = TimePoint::max();
      const TimePoint now = Clock::now();
      done_or_dropped("WebTransport's turn", [&] {
        endpoint_->expire(now);
        handle_events(now);
      });
      arm_timer();
    });
  });
}

}  // namespace gnomon::daemon
