#include "daemon/quic/connection.h"

#include <gnutls/crypto.h>

#include <algorithm>
#include <cstring>

namespace gnomon::daemon::quic {
namespace {

constexpr uint64_t kNoError = 0x100, kRequestRejected = 0x10b;  // of HTTP/3
// Streams carry a request, settings and nothing else: this bounds what a stranger makes us keep.
constexpr uint64_t kStreamBytes = 16 * 1024, kConnectionBytes = 64 * 1024, kStreams = 8;
constexpr uint64_t kLongestDatagram = 65535;  // of the frame, as WebTransport's drafts want it
constexpr size_t kLongestPacket = 1500;

// Callers read the clock apart from each other.
ngtcp2_tstamp advance(ngtcp2_tstamp& latest, TimePoint now) { return latest = std::max(latest, timestamp(now)); }

std::string key_of(const ngtcp2_cid& cid) { return {reinterpret_cast<const char*>(cid.data), cid.datalen}; }

}  // namespace

ngtcp2_tstamp timestamp(TimePoint now) { return static_cast<ngtcp2_tstamp>(now.time_since_epoch().count()); }

ngtcp2_path path_between(const Address& local, const Address& remote) {
  const auto part = [](const Address& address) {
    auto* bytes = const_cast<uint8_t*>(address.bytes.data());
    return ngtcp2_addr{reinterpret_cast<ngtcp2_sockaddr*>(bytes), address.size};
  };
  return {part(local), part(remote), nullptr};
}

// What ngtcp2 calls while it reads and writes. Nothing here may call it back to write.
struct Connection::Callbacks {
  static Connection& self(void* user) { return *static_cast<Connection*>(user); }
  static ngtcp2_callbacks all();
  static int handshake_completed(ngtcp2_conn* conn, void* user);
  static int stream_data(ngtcp2_conn* conn, uint32_t flags, int64_t stream, uint64_t offset, const uint8_t* bytes,
                         size_t size, void* user, void* stream_user);
  static int datagram(ngtcp2_conn* conn, uint32_t flags, const uint8_t* bytes, size_t size, void* user);
  static int new_id(ngtcp2_conn* conn, ngtcp2_cid* cid, uint8_t* token, size_t size, void* user);
  static int remove_id(ngtcp2_conn* conn, const ngtcp2_cid* cid, void* user);
};

ngtcp2_callbacks Connection::Callbacks::all() {
  ngtcp2_callbacks calls{};
  calls.recv_client_initial = ngtcp2_crypto_recv_client_initial_cb;
  calls.recv_crypto_data = ngtcp2_crypto_recv_crypto_data_cb;
  calls.encrypt = ngtcp2_crypto_encrypt_cb;
  calls.decrypt = ngtcp2_crypto_decrypt_cb;
  calls.hp_mask = ngtcp2_crypto_hp_mask_cb;
  calls.update_key = ngtcp2_crypto_update_key_cb;
  calls.delete_crypto_aead_ctx = ngtcp2_crypto_delete_crypto_aead_ctx_cb;
  calls.delete_crypto_cipher_ctx = ngtcp2_crypto_delete_crypto_cipher_ctx_cb;
  calls.get_path_challenge_data = ngtcp2_crypto_get_path_challenge_data_cb;
  calls.version_negotiation = ngtcp2_crypto_version_negotiation_cb;
  calls.rand = [](uint8_t* bytes, size_t size, const ngtcp2_rand_ctx*) {
    (void)gnutls_rnd(GNUTLS_RND_NONCE, bytes, size);
  };
  calls.get_new_connection_id = new_id;
  calls.remove_connection_id = remove_id;
  calls.handshake_completed = handshake_completed;
  calls.recv_stream_data = stream_data;
  calls.stream_reset = [](ngtcp2_conn*, int64_t stream, uint64_t, uint64_t, void* user, void*) {
    self(user).http_.reset(stream);
    return 0;
  };
  calls.recv_datagram = datagram;
  calls.ack_datagram = [](ngtcp2_conn*, uint64_t number, void* user) {
    self(user).event(Outcome{number, true});
    return 0;
  };
  calls.lost_datagram = [](ngtcp2_conn*, uint64_t number, void* user) {
    self(user).event(Outcome{number, false});
    return 0;
  };
  return calls;
}

int Connection::Callbacks::new_id(ngtcp2_conn*, ngtcp2_cid* cid, uint8_t* token, size_t size, void* user) {
  cid->datalen = size;
  if (gnutls_rnd(GNUTLS_RND_RANDOM, cid->data, size) < 0 ||
      gnutls_rnd(GNUTLS_RND_RANDOM, token, NGTCP2_STATELESS_RESET_TOKENLEN) < 0) {
    return NGTCP2_ERR_CALLBACK_FAILURE;
  }
  self(user).add_id(*cid);
  return 0;
}

int Connection::Callbacks::remove_id(ngtcp2_conn*, const ngtcp2_cid* cid, void* user) {
  self(user).out_.by_id.erase(key_of(*cid));
  std::erase(self(user).ids_, key_of(*cid));
  return 0;
}

int Connection::Callbacks::handshake_completed(ngtcp2_conn* conn, void* user) {
  int64_t stream = -1;
  if (ngtcp2_conn_open_uni_stream(conn, &stream, nullptr) != 0) return NGTCP2_ERR_CALLBACK_FAILURE;
  self(user).unsent_[stream].bytes = Http3::control_stream();
  return 0;
}

int Connection::Callbacks::stream_data(ngtcp2_conn* conn, uint32_t flags, int64_t stream, uint64_t,
                                       const uint8_t* bytes, size_t size, void* user, void*) {
  // What was read is kept no longer than until a frame of bounded length is whole, so the window moves at once.
  ngtcp2_conn_extend_max_offset(conn, size);
  ngtcp2_conn_extend_max_stream_offset(conn, stream, size);
  Connection& connection = self(user);
  const bool ended = (flags & NGTCP2_STREAM_DATA_FLAG_FIN) != 0;
  if (!connection.error_) connection.error_ = connection.http_.receive(stream, {bytes, size}, ended);
  return connection.error_ ? NGTCP2_ERR_CALLBACK_FAILURE : 0;
}

int Connection::Callbacks::datagram(ngtcp2_conn*, uint32_t, const uint8_t* bytes, size_t size, void* user) {
  Connection& connection = self(user);
  if (!connection.accepted_) return 0;
  if (const auto payload = connection.http_.payload({bytes, size})) {
    connection.event(Datagram{{payload->begin(), payload->end()}});
  }
  return 0;
}

std::unique_ptr<Connection> Connection::make(const Arrival& arrival, const Options& options,
                                             std::shared_ptr<const Credentials> credentials, Outbox& out,
                                             TimePoint now) {
  std::unique_ptr<Connection> made(new Connection(arrival, options, out));
  made->credentials_ = std::move(credentials);
  if (!made->begin(arrival, options, now)) return nullptr;
  return made;
}

bool Connection::begin(const Arrival& arrival, const Options& options, TimePoint now) {
  ngtcp2_settings settings;
  ngtcp2_settings_default(&settings);
  settings.initial_ts = latest_ = timestamp(now);
  // Measured with 1% of datagrams lost: BBR keeps 94 to 97% of slices fresh, CUBIC far fewer.
  settings.cc_algo = NGTCP2_CC_ALGO_BBR;
  settings.handshake_timeout = static_cast<ngtcp2_duration>(options.limits.patience.count());
  settings.token = arrival.original ? arrival.header.token : nullptr;
  settings.tokenlen = arrival.original ? arrival.header.tokenlen : 0;
  ngtcp2_transport_params params;
  ngtcp2_transport_params_default(&params);
  params.initial_max_streams_bidi = params.initial_max_streams_uni = kStreams;
  params.initial_max_stream_data_bidi_remote = params.initial_max_stream_data_uni = kStreamBytes;
  params.initial_max_data = kConnectionBytes;
  params.max_idle_timeout = static_cast<ngtcp2_duration>(options.limits.silence.count());
  params.max_datagram_frame_size = kLongestDatagram;
  params.max_udp_payload_size = kLongestPacket;
  params.original_dcid = arrival.original.value_or(arrival.header.dcid);
  params.original_dcid_present = 1;
  if (arrival.original) {
    params.retry_scid = arrival.header.dcid;
    params.retry_scid_present = 1;
  }
  ngtcp2_cid ours{};
  ours.datalen = kIdBytes;
  if (gnutls_rnd(GNUTLS_RND_RANDOM, ours.data, kIdBytes) < 0) return false;
  const ngtcp2_callbacks calls = Callbacks::all();
  const ngtcp2_path path = path_between(local_, arrival.from);
  if (ngtcp2_conn_server_new(&conn_, &arrival.header.scid, &ours, &path, arrival.header.version, &calls, &settings,
                             &params, nullptr, this) != 0) {
    return false;
  }
  tls_ = credentials_->new_session();
  if (!tls_) return false;
  ref_ = {[](ngtcp2_crypto_conn_ref* ref) { return static_cast<Connection*>(ref->user_data)->conn_; }, this};
  gnutls_session_set_ptr(tls_, &ref_);
  ngtcp2_conn_set_tls_native_handle(conn_, tls_);
  add_id(ours);
  add_id(arrival.header.dcid);
  return true;
}

Connection::~Connection() {
  for (const std::string& id : ids_) {
    const auto found = out_.by_id.find(id);
    if (found != out_.by_id.end() && found->second == id_) out_.by_id.erase(found);
  }
  if (conn_) ngtcp2_conn_del(conn_);
  if (tls_) gnutls_deinit(tls_);
}

void Connection::add_id(const ngtcp2_cid& cid) {
  if (out_.by_id.emplace(key_of(cid), id_).second) ids_.push_back(key_of(cid));
}

void Connection::receive(std::span<const uint8_t> packet, const Address& from, TimePoint now) {
  if (over_) return;
  const ngtcp2_path path = path_between(local_, from);
  const ngtcp2_pkt_info info{};
  const int failed = ngtcp2_conn_read_pkt(conn_, &path, &info, packet.data(), packet.size(), advance(latest_, now));
  if (failed != 0) return fail(failed, now);
  settle(now);
}

void Connection::expire(TimePoint now) {
  if (over_ || wake_at() > now) return;
  if (const int failed = ngtcp2_conn_handle_expiry(conn_, advance(latest_, now)); failed != 0)
    return fail(failed, now);
  settle(now);
}

void Connection::settle(TimePoint now) {
  if (auto asked = http_.take_asked(); asked && !asked_) {
    asked_ = true;
    event(std::move(*asked));
  }
  if (http_.ended()) return close(kNoError, now);
  flush(now);
  if (!over_ && std::exchange(wants_room_, false)) event(Room{});
}

void Connection::answer(int status, TimePoint now) {
  if (over_ || !asked_ || accepted_) return;
  accepted_ = status == 200;
  Unsent& unsent = unsent_[http_.session_stream()];
  unsent.bytes = http_.response(status);
  unsent.ends = !accepted_;
  flush(now);
  if (!accepted_) close(kRequestRejected, now);
}

bool Connection::flush_stream(int64_t stream, Unsent& unsent, TimePoint now) {
  std::array<uint8_t, kLongestPacket> buffer;
  ngtcp2_path_storage path;
  ngtcp2_path_storage_zero(&path);
  ngtcp2_pkt_info info{};
  ngtcp2_ssize taken = -1;
  const ngtcp2_vec data{unsent.bytes.data() + unsent.sent, unsent.bytes.size() - unsent.sent};
  const uint32_t flags = unsent.ends ? NGTCP2_WRITE_STREAM_FLAG_FIN : NGTCP2_WRITE_STREAM_FLAG_NONE;
  const ngtcp2_ssize size = ngtcp2_conn_writev_stream(conn_, &path.path, &info, buffer.data(), buffer.size(),
                                                      &taken, flags, stream, &data, 1, advance(latest_, now));
  if (taken >= 0) {
    unsent.sent += static_cast<size_t>(taken);
    unsent.ended = unsent.ends && unsent.sent == unsent.bytes.size();
  }
  if (size == NGTCP2_ERR_STREAM_DATA_BLOCKED) return false;
  if (size == NGTCP2_ERR_STREAM_NOT_FOUND || size == NGTCP2_ERR_STREAM_SHUT_WR) {
    unsent.sent = unsent.bytes.size();
    unsent.ended = unsent.ends;
    return false;
  }
  if (size < 0) {
    fail(static_cast<int>(size), now);
    return false;
  }
  if (size == 0) return false;
  emit(path, buffer.data(), static_cast<size_t>(size));
  return true;
}

// What streams have to send, then what QUIC itself has. ngtcp2 points to a stream's bytes until they are acknowledged,
// so that they stay.
void Connection::flush(TimePoint now) {
  for (auto& [stream, unsent] : unsent_) {
    while (!over_ && (unsent.sent < unsent.bytes.size() || (unsent.ends && !unsent.ended)) &&
           flush_stream(stream, unsent, now)) {
    }
  }
  Unsent nothing;
  while (!over_ && flush_stream(-1, nothing, now)) {
  }
}

bool Connection::send(uint64_t number, std::span<const uint8_t> head, std::span<const uint8_t> body,
                      TimePoint now) {
  if (over_ || !accepted_) return true;
  const std::vector<uint8_t> prefix = http_.datagram_prefix();
  std::array<ngtcp2_vec, 3> parts;
  size_t count = 0;  // of those that have bytes: ngtcp2 takes no others
  for (const std::span<const uint8_t> part : {std::span<const uint8_t>(prefix), head, body}) {
    if (!part.empty()) parts[count++] = {const_cast<uint8_t*>(part.data()), part.size()};
  }
  std::array<uint8_t, kLongestPacket> buffer;
  for (int accepted = 0; accepted == 0;) {
    ngtcp2_path_storage path;
    ngtcp2_path_storage_zero(&path);
    ngtcp2_pkt_info info{};
    const ngtcp2_ssize size = ngtcp2_conn_writev_datagram(conn_, &path.path, &info, buffer.data(), buffer.size(),
                                                          &accepted, NGTCP2_WRITE_DATAGRAM_FLAG_NONE, number,
                                                          parts.data(), count, advance(latest_, now));
    // A client that takes no datagrams, or no long ones, gets none.
    if (size == NGTCP2_ERR_INVALID_STATE || size == NGTCP2_ERR_INVALID_ARGUMENT) return true;
    if (size < 0) {
      fail(static_cast<int>(size), now);
      return true;
    }
    if (size == 0) {
      wants_room_ = true;
      return false;
    }
    emit(path, buffer.data(), static_cast<size_t>(size));
  }
  return true;
}

void Connection::emit(const ngtcp2_path_storage& path, const uint8_t* bytes, size_t size) {
  Packet& packet = out_.packets.emplace_back();
  packet.to.size = static_cast<uint32_t>(std::min<size_t>(path.path.remote.addrlen, packet.to.bytes.size()));
  std::memcpy(packet.to.bytes.data(), path.path.remote.addr, packet.to.size);
  packet.bytes.assign(bytes, bytes + size);
  burst_ += size;
}

void Connection::end_burst(TimePoint now) {
  if (std::exchange(burst_, 0) > 0 && !over_) ngtcp2_conn_update_pkt_tx_time(conn_, advance(latest_, now));
}

void Connection::close(uint64_t code, TimePoint now) {
  if (over_) return;
  ngtcp2_ccerr why;
  ngtcp2_ccerr_default(&why);
  ngtcp2_ccerr_set_application_error(&why, code, nullptr, 0);
  tell(why, now);
}

void Connection::fail(int code, TimePoint now) {
  if (over_) return;
  const bool in_silence = code == NGTCP2_ERR_DRAINING || code == NGTCP2_ERR_DROP_CONN || code == NGTCP2_ERR_RETRY ||
                          code == NGTCP2_ERR_IDLE_CLOSE || code == NGTCP2_ERR_HANDSHAKE_TIMEOUT ||
                          code == NGTCP2_ERR_CLOSING;
  ngtcp2_ccerr why;
  ngtcp2_ccerr_default(&why);
  if (error_) {
    ngtcp2_ccerr_set_application_error(&why, error_->code, nullptr, 0);
  } else if (code == NGTCP2_ERR_CRYPTO) {
    ngtcp2_ccerr_set_tls_alert(&why, ngtcp2_conn_get_tls_alert(conn_), nullptr, 0);
  } else {
    ngtcp2_ccerr_set_liberr(&why, code, nullptr, 0);
  }
  if (!in_silence) return tell(why, now);
  over_ = true;
  if (accepted_) event(Closed{});
}

void Connection::tell(const ngtcp2_ccerr& why, TimePoint now) {
  std::array<uint8_t, kLongestPacket> buffer;
  ngtcp2_path_storage path;
  ngtcp2_path_storage_zero(&path);
  ngtcp2_pkt_info info{};
  const ngtcp2_ssize size = ngtcp2_conn_write_connection_close(conn_, &path.path, &info, buffer.data(),
                                                               buffer.size(), &why, advance(latest_, now));
  if (size > 0) emit(path, buffer.data(), static_cast<size_t>(size));
  over_ = true;
  if (accepted_) event(Closed{});
}

TimePoint Connection::wake_at() const {
  const ngtcp2_tstamp expiry = ngtcp2_conn_get_expiry(conn_);
  if (expiry >= static_cast<ngtcp2_tstamp>(TimePoint::max().time_since_epoch().count())) return TimePoint::max();
  return TimePoint(Nanoseconds(static_cast<int64_t>(expiry)));
}

}  // namespace gnomon::daemon::quic
