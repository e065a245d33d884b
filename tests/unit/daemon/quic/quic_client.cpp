#include "tests/unit/daemon/quic/quic_client.h"

#include <arpa/inet.h>
#include <gnutls/crypto.h>
#include <netinet/in.h>
#include <ngtcp2/ngtcp2_crypto_gnutls.h>
#include <sys/socket.h>

#include <array>
#include <cstring>
#include <stdexcept>

#include "daemon/quic/connection.h"
#include "daemon/quic/qpack.h"
#include "daemon/quic/varint.h"

namespace gnomon::daemon::quic {
namespace {

constexpr int64_t kRequestStream = 0;

void append_frame(std::vector<uint8_t>& out, uint64_t type, std::span<const uint8_t> body) {
  append_varint(out, type);
  append_varint(out, body.size());
  out.insert(out.end(), body.begin(), body.end());
}

}  // namespace

Address address_of(const char* host, uint16_t port) {
  Address address;
  sockaddr_in four{};
  four.sin_family = AF_INET;
  four.sin_port = htons(port);
  if (inet_pton(AF_INET, host, &four.sin_addr) == 1) {
    std::memcpy(address.bytes.data(), &four, sizeof four);
    address.size = sizeof four;
    return address;
  }
  sockaddr_in6 six{};
  six.sin6_family = AF_INET6;
  six.sin6_port = htons(port);
  if (inet_pton(AF_INET6, host, &six.sin6_addr) != 1) throw std::invalid_argument(host);
  std::memcpy(address.bytes.data(), &six, sizeof six);
  address.size = sizeof six;
  return address;
}

QuicClient::Request QuicClient::session_request(const std::string& path, const std::string& origin) {
  return {{":method", "CONNECT"}, {":protocol", "webtransport"},
          {":scheme", "https"},   {":authority", "here:7600"},
          {":path", path},        {"origin", origin}};
}

QuicClient::QuicClient(const Address& local, const Address& server, Request request, TimePoint now)
    : local_(local), seen_at_(local), server_(server), request_(std::move(request)) {
  ngtcp2_settings settings;
  ngtcp2_settings_default(&settings);
  settings.initial_ts = timestamp(now);
  ngtcp2_transport_params params;
  ngtcp2_transport_params_default(&params);
  params.initial_max_streams_bidi = params.initial_max_streams_uni = 8;
  params.initial_max_stream_data_bidi_local = params.initial_max_stream_data_uni = 65536;
  params.initial_max_data = 1 << 20;
  params.max_datagram_frame_size = 65535;
  ngtcp2_cid theirs{}, ours{};
  theirs.datalen = 18;
  ours.datalen = 8;
  (void)gnutls_rnd(GNUTLS_RND_RANDOM, theirs.data, theirs.datalen);
  (void)gnutls_rnd(GNUTLS_RND_RANDOM, ours.data, ours.datalen);
  const ngtcp2_callbacks calls = callbacks();
  const ngtcp2_path between = path();
  if (ngtcp2_conn_client_new(&conn_, &theirs, &ours, &between, NGTCP2_PROTO_VER_V1, &calls, &settings, &params,
                             nullptr, this) != 0) {
    throw std::runtime_error("no connection");
  }
  gnutls_certificate_allocate_credentials(&credentials_);
  gnutls_init(&tls_, GNUTLS_CLIENT);
  gnutls_priority_set_direct(tls_, "NORMAL:-VERS-ALL:+VERS-TLS1.3:%DISABLE_TLS13_COMPAT_MODE", nullptr);
  ngtcp2_crypto_gnutls_configure_client_session(tls_);
  gnutls_credentials_set(tls_, GNUTLS_CRD_CERTIFICATE, credentials_);
  unsigned char name[] = {'h', '3'};
  const gnutls_datum_t protocol{name, 2};
  gnutls_alpn_set_protocols(tls_, &protocol, 1, GNUTLS_ALPN_MANDATORY);
  ref_ = {[](ngtcp2_crypto_conn_ref* ref) { return self(ref->user_data).conn_; }, this};
  gnutls_session_set_ptr(tls_, &ref_);
  ngtcp2_conn_set_tls_native_handle(conn_, tls_);
}

QuicClient::~QuicClient() {
  ngtcp2_conn_del(conn_);
  gnutls_deinit(tls_);
  gnutls_certificate_free_credentials(credentials_);
}

ngtcp2_path QuicClient::path() const { return path_between(local_, server_); }

ngtcp2_callbacks QuicClient::callbacks() {
  ngtcp2_callbacks calls{};
  calls.client_initial = ngtcp2_crypto_client_initial_cb;
  calls.recv_retry = [](ngtcp2_conn* conn, const ngtcp2_pkt_hd* header, void* user) {
    self(user).retried_ = true;
    return ngtcp2_crypto_recv_retry_cb(conn, header, user);
  };
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
  calls.get_new_connection_id = [](ngtcp2_conn*, ngtcp2_cid* cid, uint8_t* token, size_t size, void*) {
    cid->datalen = size;
    (void)gnutls_rnd(GNUTLS_RND_RANDOM, cid->data, size);
    (void)gnutls_rnd(GNUTLS_RND_RANDOM, token, NGTCP2_STATELESS_RESET_TOKENLEN);
    return 0;
  };
  calls.handshake_completed = [](ngtcp2_conn*, void* user) { return self(user).on_handshake_done(); };
  calls.recv_stream_data = [](ngtcp2_conn*, uint32_t, int64_t stream, uint64_t, const uint8_t* bytes, size_t size,
                              void* user, void*) {
    self(user).on_stream(stream, {bytes, size});
    return 0;
  };
  calls.recv_datagram = [](ngtcp2_conn*, uint32_t, const uint8_t* bytes, size_t size, void* user) {
    std::span<const uint8_t> rest(bytes, size);
    if (take_varint(rest)) self(user).datagrams_.emplace_back(rest.begin(), rest.end());
    return 0;
  };
  return calls;
}

int QuicClient::on_handshake_done() {
  int64_t control = -1, request = -1;
  if (ngtcp2_conn_open_uni_stream(conn_, &control, nullptr) != 0 ||
      ngtcp2_conn_open_bidi_stream(conn_, &request, nullptr) != 0) {
    return NGTCP2_ERR_CALLBACK_FAILURE;
  }
  std::vector<uint8_t> settings;
  for (const uint64_t id : {0x08, 0x33, 0x2b603742}) {
    append_varint(settings, id);
    append_varint(settings, 1);
  }
  append_varint(unsent_[control].bytes, 0);
  append_frame(unsent_[control].bytes, 4, settings);
  append_frame(unsent_[request].bytes, 1, encode_fields(request_));
  return 0;
}

void QuicClient::on_stream(int64_t stream, std::span<const uint8_t> bytes) {
  if (stream != kRequestStream) {
    server_control_.insert(server_control_.end(), bytes.begin(), bytes.end());
    return;
  }
  answer_.insert(answer_.end(), bytes.begin(), bytes.end());
  std::span<const uint8_t> rest = answer_;
  const auto type = take_varint(rest), length = take_varint(rest);
  if (!type || !length || rest.size() < *length || status_) return;
  if (const auto fields = decode_fields(rest.first(*length))) status_ = std::stoi(fields->at(":status"));
}

void QuicClient::receive(std::span<const uint8_t> packet, TimePoint now) {
  if (over_) return;
  const ngtcp2_path between = path();
  const ngtcp2_pkt_info info{};
  const int failed = ngtcp2_conn_read_pkt(conn_, &between, &info, packet.data(), packet.size(), timestamp(now));
  over_ = failed != 0;
}

void QuicClient::expire(TimePoint now) {
  if (!over_ && wake_at() <= now) over_ = ngtcp2_conn_handle_expiry(conn_, timestamp(now)) != 0;
}

TimePoint QuicClient::wake_at() const {
  const ngtcp2_tstamp expiry = ngtcp2_conn_get_expiry(conn_);
  return expiry == UINT64_MAX ? TimePoint::max() : TimePoint(Nanoseconds(static_cast<int64_t>(expiry)));
}

std::vector<std::vector<uint8_t>> QuicClient::take_packets(TimePoint now) {
  std::array<uint8_t, 1500> buffer;
  while (!over_) {
    ngtcp2_path_storage storage;
    ngtcp2_path_storage_zero(&storage);
    ngtcp2_pkt_info info{};
    ngtcp2_ssize size = 0, taken = -1;
    auto stream = unsent_.begin();
    while (stream != unsent_.end() && stream->second.sent == stream->second.bytes.size()) ++stream;
    if (stream == unsent_.end() && !outgoing_.empty()) {
      int accepted = 0;
      const ngtcp2_vec data{outgoing_.front().data(), outgoing_.front().size()};
      size = ngtcp2_conn_writev_datagram(conn_, &storage.path, &info, buffer.data(), buffer.size(), &accepted, 0, 1,
                                         &data, 1, timestamp(now));
      if (accepted) outgoing_.erase(outgoing_.begin());
    } else {
      const int64_t id = stream == unsent_.end() ? -1 : stream->first;
      ngtcp2_vec data{};
      if (id >= 0)
        data = {stream->second.bytes.data() + stream->second.sent,
                stream->second.bytes.size() - stream->second.sent};
      size = ngtcp2_conn_writev_stream(conn_, &storage.path, &info, buffer.data(), buffer.size(), &taken, 0, id,
                                       &data, id >= 0 ? 1 : 0, timestamp(now));
      if (taken > 0) stream->second.sent += static_cast<size_t>(taken);
    }
    if (size <= 0) break;
    packets_.emplace_back(buffer.data(), buffer.data() + size);
  }
  ngtcp2_conn_update_pkt_tx_time(conn_, timestamp(now));
  return std::exchange(packets_, {});
}

void QuicClient::send_datagram(std::vector<uint8_t> payload) {
  payload.insert(payload.begin(), 0);  // the session's stream is the first one
  outgoing_.push_back(std::move(payload));
}

void QuicClient::send_on_stream(int64_t stream, std::vector<uint8_t> bytes) {
  auto& unsent = unsent_[stream].bytes;
  unsent.insert(unsent.end(), bytes.begin(), bytes.end());
}

void QuicClient::close(TimePoint now) {
  std::array<uint8_t, 1500> buffer;
  ngtcp2_ccerr why;
  ngtcp2_ccerr_default(&why);
  const ngtcp2_ssize size = ngtcp2_conn_write_connection_close(conn_, nullptr, nullptr, buffer.data(),
                                                               buffer.size(), &why, timestamp(now));
  if (size > 0) packets_.emplace_back(buffer.data(), buffer.data() + size);
  over_ = true;
}

uint64_t QuicClient::error_code() const { return ngtcp2_conn_get_ccerr(conn_)->error_code; }

}  // namespace gnomon::daemon::quic
