// A browser's side of WebTransport, as far as tests need one: ngtcp2 as a client, HTTP/3 by hand. No socket, no clock.
#pragma once

#include <gnutls/gnutls.h>
#include <ngtcp2/ngtcp2.h>
#include <ngtcp2/ngtcp2_crypto.h>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/quic/endpoint.h"

namespace gnomon::daemon::quic {

Address address_of(const char* host, uint16_t port);  // IPv4 or IPv6

class QuicClient {
 public:
  // The fields of its request, in the order sent.
  using Request = std::vector<std::pair<std::string, std::string>>;
  static Request session_request(const std::string& path, const std::string& origin = "https://here:7600");

  QuicClient(const Address& local, const Address& server, Request request, TimePoint now);
  ~QuicClient();
  QuicClient(const QuicClient&) = delete;
  QuicClient& operator=(const QuicClient&) = delete;

  const Address& address() const { return seen_at_; }           // where the server sees it
  void move_to(const Address& address) { seen_at_ = address; }  // by a NAT that rebinds: it does not know

  void receive(std::span<const uint8_t> packet, TimePoint now);
  void expire(TimePoint now);
  TimePoint wake_at() const;
  std::vector<std::vector<uint8_t>> take_packets(TimePoint now);

  void send_datagram(std::vector<uint8_t> payload);                 // of its session
  void send_on_stream(int64_t stream, std::vector<uint8_t> bytes);  // raw, on one of its streams
  std::vector<std::vector<uint8_t>> take_datagrams() { return std::exchange(datagrams_, {}); }
  void close(TimePoint now);

  std::optional<int> status() const { return status_; }  // of the answer to its request
  bool is_over() const { return over_; }
  uint64_t error_code() const;  // that the server has closed the connection with
  bool was_retried() const { return retried_; }
  std::vector<uint8_t> server_control() const { return server_control_; }  // bytes of the server's control stream

 private:
  struct Unsent {
    std::vector<uint8_t> bytes;
    size_t sent = 0;
  };
  static QuicClient& self(void* user) { return *static_cast<QuicClient*>(user); }
  static ngtcp2_callbacks callbacks();
  int on_handshake_done();
  void on_stream(int64_t stream, std::span<const uint8_t> bytes);
  ngtcp2_path path() const;

  Address local_, seen_at_, server_;
  Request request_;
  ngtcp2_conn* conn_ = nullptr;
  gnutls_certificate_credentials_t credentials_ = nullptr;
  gnutls_session_t tls_ = nullptr;
  ngtcp2_crypto_conn_ref ref_{};
  std::map<int64_t, Unsent> unsent_;
  std::vector<std::vector<uint8_t>> outgoing_, datagrams_, packets_;
  std::vector<uint8_t> answer_, server_control_;
  std::optional<int> status_;
  bool over_ = false, retried_ = false;
};

}  // namespace gnomon::daemon::quic
