#include "daemon/quic/server.h"

#include <gnutls/crypto.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstring>

namespace gnomon::daemon::quic {
namespace {

constexpr ngtcp2_duration kTokenLasts = 10 * NGTCP2_SECONDS;
constexpr size_t kShortestInitial = 1200;  // RFC 9000, 14.1
constexpr uint64_t kShuttingDown = 0x100;

// An IPv4 address, or the first 64 bits of an IPv6 one, which is what one subscriber has.
std::string network_of(const Address& address) {
  if (address.size == sizeof(sockaddr_in)) {
    const size_t at = offsetof(sockaddr_in, sin_addr);
    return {reinterpret_cast<const char*>(address.bytes.data()) + at, 4};
  }
  const char* bytes = reinterpret_cast<const char*>(address.bytes.data()) + offsetof(sockaddr_in6, sin6_addr);
  in6_addr six;
  std::memcpy(&six, bytes, sizeof six);
  return IN6_IS_ADDR_V4MAPPED(&six) ? std::string(bytes + 12, 4) : std::string(bytes, 8);
}

}  // namespace

bool is_built_in() { return true; }

Result<std::unique_ptr<Endpoint>> make_endpoint(const Options& options) {
  auto made = std::make_unique<Server>(options);
  if (auto used = made->set_identity(options.identity); !used) return used.error();
  return std::unique_ptr<Endpoint>(std::move(made));
}

Server::Server(const Options& options)
    : options_(options),
      unvalidated_(options.limits.unvalidated_per_s, options.limits.unvalidated_per_s),
      handshakes_(static_cast<double>(options.limits.per_network), options.limits.per_network_per_s) {
  (void)gnutls_rnd(GNUTLS_RND_RANDOM, secret_.data(), secret_.size());
}

Result<void> Server::set_identity(const Identity& identity) {
  auto made = Credentials::make(identity);
  if (!made) return made.error();
  credentials_ = std::move(*made);
  return {};
}

void Server::receive(std::span<const uint8_t> packet, const Address& from, TimePoint now) {
  if (packet.empty()) return;  // which ngtcp2 takes for a bug of ours
  ngtcp2_version_cid ids{};
  const int failed = ngtcp2_pkt_decode_version_cid(&ids, packet.data(), packet.size(), kIdBytes);
  if (failed == NGTCP2_ERR_VERSION_NEGOTIATION) return negotiate_version(ids, packet.size(), from);
  if (failed != 0) return;
  const auto known = out_.by_id.find(std::string_view(reinterpret_cast<const char*>(ids.dcid), ids.dcidlen));
  if (known == out_.by_id.end()) return begin(packet, from, now);
  const ConnectionId id = known->second;
  if (Connection* const connection = find(id)) connection->receive(packet, from, now);
  settle(id);
}

// The first packet of a client. What cannot be one gets no answer.
void Server::begin(std::span<const uint8_t> packet, const Address& from, TimePoint now) {
  Arrival arrival;
  arrival.from = from;
  if (packet.size() < kShortestInitial || ngtcp2_accept(&arrival.header, packet.data(), packet.size()) != 0) return;
  if (is_full(from)) return;
  if (arrival.header.tokenlen > 0) {
    ngtcp2_cid original;
    const ngtcp2_path path = path_between(options_.local, from);
    const bool validated = ngtcp2_crypto_verify_retry_token2(
                               &original, arrival.header.token, arrival.header.tokenlen, secret_.data(),
                               secret_.size(), arrival.header.version, path.remote.addr, path.remote.addrlen,
                               &arrival.header.dcid, kTokenLasts, timestamp(now)) == 0;
    if (validated) arrival.original = original;
  }
  if (!arrival.original && arrival.header.dcid.datalen < NGTCP2_MIN_INITIAL_DCIDLEN) return;  // RFC 9000, 7.2
  if (!arrival.original && (half_open_.size() >= options_.limits.retry_above || !unvalidated_.take(1, now))) {
    return ask_to_retry(arrival.header, from, now);
  }
  // Who has not proved its address may have written anybody's.
  if (arrival.original && !handshakes_.take(network_of(from), 1, now)) return;
  arrival.id = ++newest_;
  auto connection = Connection::make(arrival, options_, credentials_, out_, now);
  if (!connection) return;
  ++per_network_[network_of(from)];
  half_open_.emplace(arrival.id, now);
  const auto& placed = connections_.emplace(arrival.id, Timed{std::move(connection)}).first->second;
  placed.connection->receive(packet, from, now);
  settle(arrival.id);
}

bool Server::is_full(const Address& from) const {
  const auto network = per_network_.find(network_of(from));
  return connections_.size() >= options_.limits.connections || half_open_.size() >= options_.limits.half_open ||
         (network != per_network_.end() && network->second >= options_.limits.per_network);
}

void Server::ask_to_retry(const ngtcp2_pkt_hd& header, const Address& from, TimePoint now) {
  ngtcp2_cid ours{};
  ours.datalen = kIdBytes;
  if (gnutls_rnd(GNUTLS_RND_RANDOM, ours.data, kIdBytes) < 0) return;
  std::array<uint8_t, NGTCP2_CRYPTO_MAX_RETRY_TOKENLEN2> token;
  const ngtcp2_path path = path_between(options_.local, from);
  const ngtcp2_ssize token_bytes = ngtcp2_crypto_generate_retry_token2(
      token.data(), secret_.data(), secret_.size(), header.version, path.remote.addr, path.remote.addrlen, &ours,
      &header.dcid, timestamp(now));
  if (token_bytes < 0) return;
  Packet packet{from, std::vector<uint8_t>(kShortestInitial)};
  const ngtcp2_ssize size =
      ngtcp2_crypto_write_retry(packet.bytes.data(), packet.bytes.size(), header.version, &header.scid, &ours,
                                &header.dcid, token.data(), static_cast<size_t>(token_bytes));
  if (size <= 0) return;
  packet.bytes.resize(static_cast<size_t>(size));
  out_.packets.push_back(std::move(packet));
}

// An answer is shorter than what asks for it, so that nobody is flooded by it.
void Server::negotiate_version(const ngtcp2_version_cid& ids, size_t packet_bytes, const Address& from) {
  if (packet_bytes < kShortestInitial) return;
  const uint32_t versions[] = {NGTCP2_PROTO_VER_V1};
  uint8_t unused = 0;
  (void)gnutls_rnd(GNUTLS_RND_NONCE, &unused, 1);
  Packet packet{from, std::vector<uint8_t>(kShortestInitial)};
  const ngtcp2_ssize size =
      ngtcp2_pkt_write_version_negotiation(packet.bytes.data(), packet.bytes.size(), unused, ids.scid, ids.scidlen,
                                           ids.dcid, ids.dcidlen, versions, std::size(versions));
  if (size <= 0) return;
  packet.bytes.resize(static_cast<size_t>(size));
  out_.packets.push_back(std::move(packet));
}

void Server::expire(TimePoint now) {
  while (!times_.empty() && times_.begin()->first <= now) {
    const ConnectionId id = times_.begin()->second;
    Connection* const connection = find(id);
    const TimePoint before = times_.begin()->first;
    connection->expire(now);
    settle(id);
    // A timer that has not moved is one that has nothing to do: it is looked at again a little later.
    const auto found = connections_.find(id);
    if (found != connections_.end() && found->second.wake_at <= before) {
      times_.erase({found->second.wake_at, id});
      found->second.wake_at = now + std::chrono::milliseconds(1);
      times_.emplace(found->second.wake_at, id);
    }
  }
  std::vector<ConnectionId> overdue;
  for (const auto& [id, began] : half_open_) {
    if (began + options_.limits.patience <= now) overdue.push_back(id);
  }
  for (const ConnectionId id : overdue) close(id, now);
}

TimePoint Server::wake_at() const {
  // Ids count up, so that the first one is the oldest.
  const TimePoint half_open =
      half_open_.empty() ? TimePoint::max() : half_open_.begin()->second + options_.limits.patience;
  return times_.empty() ? half_open : std::min(half_open, times_.begin()->first);
}

std::vector<Packet> Server::take_packets(TimePoint now) {
  for (const ConnectionId id : std::exchange(sent_, {})) {
    if (Connection* const connection = find(id)) connection->end_burst(now);
    settle(id);
  }
  sent_.clear();
  return std::exchange(out_.packets, {});
}

void Server::accept(ConnectionId id, TimePoint now) {
  Connection* const connection = find(id);
  if (!connection) return;
  connection->answer(200, now);
  if (connection->is_open()) half_open_.erase(id);
  settle(id);
}

void Server::refuse(ConnectionId id, int status, TimePoint now) {
  if (Connection* const connection = find(id)) connection->answer(status, now);
  settle(id);
}

bool Server::send(ConnectionId id, uint64_t number, std::span<const uint8_t> head, std::span<const uint8_t> body,
                  TimePoint now) {
  Connection* const connection = find(id);
  if (!connection) return true;
  const bool taken = connection->send(number, head, body, now);
  settle(id);
  return taken;
}

void Server::close(ConnectionId id, TimePoint now) {
  if (Connection* const connection = find(id)) connection->close(kShuttingDown, now);
  settle(id);
}

Connection* Server::find(ConnectionId id) {
  const auto found = connections_.find(id);
  return found == connections_.end() ? nullptr : found->second.connection.get();
}

void Server::settle(ConnectionId id) {
  const auto found = connections_.find(id);
  if (found == connections_.end()) return;
  if (found->second.connection->is_over()) return drop(id);
  sent_.insert(id);
  const TimePoint when = found->second.connection->wake_at();
  if (when == found->second.wake_at) return;
  times_.erase({found->second.wake_at, id});
  found->second.wake_at = when;
  if (when != TimePoint::max()) times_.emplace(when, id);
}

void Server::drop(ConnectionId id) {
  const auto found = connections_.find(id);
  times_.erase({found->second.wake_at, id});
  const auto network = per_network_.find(network_of(found->second.connection->began_at()));
  if (--network->second == 0) per_network_.erase(network);
  half_open_.erase(id);
  connections_.erase(found);
}

}  // namespace gnomon::daemon::quic
