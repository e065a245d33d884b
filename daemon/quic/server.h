// The endpoint of real connections: whom it lets in, and which packet is whose.
#pragma once

#include <map>
#include <memory>
#include <set>
#include <utility>

#include "common/token_buckets.h"
#include "daemon/quic/connection.h"
#include "daemon/quic/endpoint.h"

namespace gnomon::daemon::quic {

class Server : public Endpoint {
 public:
  explicit Server(const Options& options);

  Result<void> set_identity(const Identity& identity) override;
  void receive(std::span<const uint8_t> packet, const Address& from, TimePoint now) override;
  void expire(TimePoint now) override;
  TimePoint wake_at() const override;
  std::vector<Event> take_events() override { return std::exchange(out_.events, {}); }
  std::vector<Packet> take_packets(TimePoint now) override;
  void accept(ConnectionId id, TimePoint now) override;
  void refuse(ConnectionId id, int status, TimePoint now) override;
  bool send(ConnectionId id, uint64_t number, std::span<const uint8_t> head, std::span<const uint8_t> body,
            TimePoint now) override;
  void close(ConnectionId id, TimePoint now) override;
  size_t connections() const override { return connections_.size(); }
  size_t half_open() const override { return half_open_.size(); }

 private:
  struct Timed {
    std::unique_ptr<Connection> connection;
    TimePoint wake_at = TimePoint::max();
  };

  void begin(std::span<const uint8_t> packet, const Address& from, TimePoint now);
  bool is_full(const Address& from) const;
  void ask_to_retry(const ngtcp2_pkt_hd& header, const Address& from, TimePoint now);
  void negotiate_version(const ngtcp2_version_cid& ids, size_t packet_bytes, const Address& from);
  Connection* find(ConnectionId id);
  // After each call of a connection: it is dropped if it is over, else its time is noted.
  void settle(ConnectionId id);
  void drop(ConnectionId id);

  Options options_;
  std::shared_ptr<const Credentials> credentials_;
  std::array<uint8_t, 32> secret_{};  // of Retry's tokens
  Outbox out_;
  std::map<ConnectionId, Timed> connections_;
  std::map<ConnectionId, TimePoint> half_open_;  // each with the time at which it began
  std::map<std::string, size_t> per_network_;
  // A handshake costs a server more than a client, also one that is given up with its first packet.
  TokenBucket unvalidated_;
  TokenBuckets<std::string> handshakes_;
  std::set<std::pair<TimePoint, ConnectionId>> times_;
  std::set<ConnectionId> sent_;  // since the last take_packets()
  ConnectionId newest_ = 0;
};

}  // namespace gnomon::daemon::quic
