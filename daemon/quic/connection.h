// One QUIC connection (ngtcp2) with HTTP/3 on it.
#pragma once

#include <gnutls/gnutls.h>
#include <ngtcp2/ngtcp2.h>
#include <ngtcp2/ngtcp2_crypto.h>

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "daemon/quic/endpoint.h"
#include "daemon/quic/http3.h"
#include "daemon/quic/tls.h"

namespace gnomon::daemon::quic {

inline constexpr size_t kIdBytes = 16;  // of the ids that we give to connections

// What all connections of an endpoint write to, and who finds them by their ids.
struct Outbox {
  std::vector<Event> events;
  std::vector<Packet> packets;
  std::map<std::string, ConnectionId, std::less<>> by_id;  // connection ids as they stand in packets
};

// What the first packet of a client said.
struct Arrival {
  ConnectionId id = 0;
  ngtcp2_pkt_hd header{};
  std::optional<ngtcp2_cid> original;  // the id that the client chose first, where it has come again after a Retry
  Address from;
};

ngtcp2_tstamp timestamp(TimePoint now);
ngtcp2_path path_between(const Address& local, const Address& remote);

// One thread. Outlived by the outbox. Not copied: ngtcp2 and GnuTLS point to it.
class Connection {
 public:
  // nullptr if the packet begins no connection.
  static std::unique_ptr<Connection> make(const Arrival& arrival, const Options& options,
                                          std::shared_ptr<const Credentials> credentials, Outbox& out,
                                          TimePoint now);
  ~Connection();
  Connection(const Connection&) = delete;

  ConnectionId id() const { return id_; }
  const Address& began_at() const { return began_at_; }
  bool is_open() const { return accepted_; }  // its session was accepted
  bool is_over() const { return over_; }
  TimePoint wake_at() const;

  void receive(std::span<const uint8_t> packet, const Address& from, TimePoint now);
  void expire(TimePoint now);

  // Answers the session that it asks for, with a status of HTTP: 200 accepts it, others close the connection.
  void answer(int status, TimePoint now);
  bool send(uint64_t number, std::span<const uint8_t> head, std::span<const uint8_t> body, TimePoint now);
  // Tells the client, once, with an error code of HTTP/3. It is over then.
  void close(uint64_t code, TimePoint now);
  // After what was sent in one go: the pace counts from here.
  void end_burst(TimePoint now);

 private:
  struct Callbacks;
  struct Unsent {  // of one of our streams
    std::vector<uint8_t> bytes;
    size_t sent = 0;
    bool ends = false;
    bool ended = false;
  };

  Connection(const Arrival& arrival, const Options& options, Outbox& out)
      : id_(arrival.id), began_at_(arrival.from), local_(options.local), out_(out) {}
  bool begin(const Arrival& arrival, const Options& options, TimePoint now);
  void add_id(const ngtcp2_cid& cid);
  void settle(TimePoint now);  // after each call of ngtcp2 that may have had callbacks
  void flush(TimePoint now);
  bool flush_stream(int64_t stream, Unsent& unsent, TimePoint now);
  void emit(const ngtcp2_path_storage& path, const uint8_t* bytes, size_t size);
  void fail(int why, TimePoint now);
  void tell(const ngtcp2_ccerr& why, TimePoint now);
  void event(decltype(Event::what) what) { out_.events.push_back({id_, std::move(what)}); }

  ConnectionId id_;
  Address began_at_;
  Address local_;
  Outbox& out_;
  std::shared_ptr<const Credentials> credentials_;
  ngtcp2_conn* conn_ = nullptr;
  gnutls_session_t tls_ = nullptr;
  ngtcp2_crypto_conn_ref ref_{};
  std::vector<std::string> ids_;
  Http3 http_;
  std::optional<Http3Error> error_;  // of what the client sent, found in a callback
  std::map<int64_t, Unsent> unsent_;
  ngtcp2_tstamp latest_ = 0;  // ngtcp2 ends the process where time goes back
  size_t burst_ = 0;          // bytes since the pace was counted last
  bool asked_ = false;
  bool accepted_ = false;
  bool wants_room_ = false;
  bool over_ = false;
};

}  // namespace gnomon::daemon::quic
