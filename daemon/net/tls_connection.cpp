#include "daemon/net/tls_connection.h"

#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/ssl.h>
#include <sys/socket.h>

#include <algorithm>
#include <asio/buffer.hpp>
#include <asio/post.hpp>
#include <asio/ssl/error.hpp>
#include <asio/write.hpp>
#include <utility>

#include "daemon/net/proxy_header.h"

namespace gnomon::daemon {
namespace {

// A client should send close_notify, but its Bye is what counts: a plain close of the connection is accepted too.
bool is_end(const asio::error_code& error) {
  return error == asio::error::eof || error == asio::ssl::error::stream_truncated;
}

constexpr size_t kMaxTogether = 16 * 1024;  // bytes; one TLS record
// Bytes that the kernel may hold unsent. More would age there, while frames that wait in the link can be dropped.
constexpr int kUnsentInKernel = 32 * 1024;

Fault fault_of_handshake(const asio::error_code& error) {
  if (error.category() != asio::error::get_ssl_category()) return Fault::handshake_abandoned;
  switch (ERR_GET_REASON(static_cast<unsigned long>(error.value()))) {
    case SSL_R_UNSUPPORTED_PROTOCOL: return Fault::tls_version;
    case SSL_R_CERTIFICATE_VERIFY_FAILED: return Fault::tls_certificate;
    case SSL_R_SSLV3_ALERT_BAD_CERTIFICATE:
    case SSL_R_SSLV3_ALERT_CERTIFICATE_EXPIRED:
    case SSL_R_SSLV3_ALERT_CERTIFICATE_UNKNOWN:
    case SSL_R_TLSV1_ALERT_UNKNOWN_CA: return Fault::tls_distrusted;
    default: return Fault::tls_failed;
  }
}

// Looks at what has come without taking it.
bool begins_as_of_proxy(asio::ip::tcp::socket& socket) {
  std::array<uint8_t, kProxyStartBytes> first{};
  const ssize_t bytes = recv(socket.native_handle(), first.data(), first.size(), MSG_PEEK | MSG_DONTWAIT);
  return bytes > 0 && is_proxy_start(std::span(first).first(static_cast<size_t>(bytes)));
}

}  // namespace

TlsConnection::TlsConnection(asio::ip::tcp::socket socket, const asio::ip::address& client, asio::ssl::context& tls)
    : stream_(std::move(socket), tls), peer_(client) {
  asio::error_code ignored;
  stream_.next_layer().set_option(asio::ip::tcp::no_delay(true), ignored);
  setsockopt(stream_.next_layer().native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentInKernel,
             sizeof kUnsentInKernel);
  reached_ = stream_.next_layer().local_endpoint(ignored);
}

// The first bytes are looked at before OpenSSL takes them: what it says of a PROXY header, "wrong version number", tells an
// operator nothing of the door that is missing in the configuration.
void TlsConnection::start() {
  stream_.next_layer().async_wait(
      asio::ip::tcp::socket::wait_read, [self = shared_from_this()](asio::error_code error) {
        if (error) return self->end(Fault::handshake_abandoned, error.message());
        if (begins_as_of_proxy(self->stream_.next_layer())) {
          return self->end(Fault::proxy_unlisted, "a door that is not in the configuration, or a stranger");
        }
        self->stream_.async_handshake(asio::ssl::stream_base::server, [self](asio::error_code failed) {
          if (failed) return self->end(fault_of_handshake(failed), failed.message());
          self->on_open();
          if (self->is_open()) self->read();
        });
      });
}

void TlsConnection::read() {
  stream_.async_read_some(
      asio::buffer(incoming_), [self = shared_from_this()](asio::error_code error, size_t bytes) {
        if (is_end(error) && self->finishing_ && !self->outgoing_.empty()) {
          self->peer_ended_ = true;  // the client may have closed its sending side only, and still read
          return;
        }
        if (error) {
          return self->end(Fault::handshake_abandoned, is_end(error) ? "closed by the client" : error.message());
        }
        if (!self->finishing_) self->on_bytes(std::span(self->incoming_).first(bytes));
        if (self->is_open()) self->read();
      });
}

// Small messages that wait are joined: a TLS record and a system call for each would cost more than the copy.
void TlsConnection::send_bytes(std::vector<uint8_t> bytes) {
  if (!is_open() || finishing_) return;
  unsent_bytes_ += bytes.size();
  if (outgoing_.size() > 1 && !outgoing_.back().shared &&
      outgoing_.back().own.size() + bytes.size() <= kMaxTogether) {
    outgoing_.back().own.insert(outgoing_.back().own.end(), bytes.begin(), bytes.end());
    return;
  }
  queue({.own = std::move(bytes)});
}

void TlsConnection::send_bytes(web::SharedBytes bytes) {
  if (is_open() && !finishing_) queue({.own = {}, .shared = std::move(bytes)});
}

void TlsConnection::queue(Outgoing outgoing) {
  outgoing_.push_back(std::move(outgoing));
  if (outgoing_.size() == 1) write();
}

// A record at a time, so that it shows how much the client takes.
void TlsConnection::write() {
  const std::span<const uint8_t> rest = outgoing_.front().rest();
  asio::async_write(stream_, asio::buffer(rest.data(), std::min(rest.size(), kMaxTogether)),
                    [self = shared_from_this()](asio::error_code error, size_t bytes) {
                      if (error) return self->end(Fault::handshake_abandoned, error.message());
                      self->written(bytes);
                    });
}

void TlsConnection::written(size_t bytes) {
  Outgoing& front = outgoing_.front();
  front.sent += bytes;
  if (!front.shared) unsent_bytes_ -= bytes;
  if (front.rest().empty()) outgoing_.pop_front();
  if (!outgoing_.empty()) {
    write();
  } else if (finishing_) {
    return all_written();
  }
  on_sent(bytes);
}

void TlsConnection::finish_sending() {
  finishing_ = true;
  if (outgoing_.empty()) all_written();
}

// Closing the socket while bytes of the client are unread would reset the connection, and the client could lose our
// last messages.
void TlsConnection::all_written() {
  if (peer_ended_) return close_socket();
  stream_.async_shutdown([self = shared_from_this()](asio::error_code) {
    asio::error_code ignored;
    self->stream_.lowest_layer().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
  });
}

void TlsConnection::close_socket() {
  ended_ = true;
  asio::error_code ignored;
  stream_.lowest_layer().close(ignored);
}

void TlsConnection::end_later(const std::string& why) {
  asio::post(stream_.get_executor(),
             [self = shared_from_this(), why] { self->end(Fault::handshake_abandoned, why); });
}

void TlsConnection::end(Fault fault, const std::string& why) {
  const bool by_itself = !std::exchange(ended_, true);
  close_socket();
  if (by_itself) on_ended(fault, why);
}

}  // namespace gnomon::daemon
