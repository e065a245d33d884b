#include "daemon/net/control_stream.h"

#include <netinet/tcp.h>
#include <openssl/err.h>
#include <openssl/ssl.h>

#include <asio/buffer.hpp>
#include <asio/post.hpp>
#include <asio/ssl/error.hpp>
#include <asio/write.hpp>
#include <utility>

#include "protocol/seal_exporter.h"

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

}  // namespace

ControlStream::ControlStream(asio::ip::tcp::socket socket, asio::ssl::context& tls, size_t max_message_bytes)
    : stream_(std::move(socket), tls), reader_(max_message_bytes) {
  asio::error_code ignored;
  stream_.next_layer().set_option(asio::ip::tcp::no_delay(true), ignored);
  setsockopt(stream_.next_layer().native_handle(), IPPROTO_TCP, TCP_NOTSENT_LOWAT, &kUnsentInKernel,
             sizeof kUnsentInKernel);
  peer_ = stream_.next_layer().remote_endpoint(ignored).address();
}

void ControlStream::listen(OnMessage on_message, OnEnd on_end) {
  on_message_ = std::move(on_message);
  on_end_ = std::move(on_end);
}

void ControlStream::start() { shake_hands(); }

void ControlStream::shake_hands() {
  stream_.async_handshake(asio::ssl::stream_base::server, [self = shared_from_this()](asio::error_code error) {
    if (error) return self->end(fault_of_handshake(error), error.message());
    self->read();
  });
}

void ControlStream::read() {
  stream_.async_read_some(
      asio::buffer(incoming_), [self = shared_from_this()](asio::error_code error, size_t bytes) {
        if (is_end(error) && self->finishing_ && !self->outgoing_.empty()) {
          self->peer_ended_ = true;  // the client may have closed its sending side only, and still read
          return;
        }
        if (error) {
          return self->end(Fault::handshake_abandoned, is_end(error) ? "closed by the client" : error.message());
        }
        if (!self->finishing_) {
          self->reader_.feed(std::span(self->incoming_).first(bytes));
          self->deliver_messages();
        }
        if (self->is_open()) self->read();
      });
}

void ControlStream::deliver_messages() {
  while (!finishing_ && on_message_) {
    auto message = reader_.next();
    const OnMessage on_message = on_message_;  // a copy, as the callee may end the connection and reset the member
    if (!message) {
      on_message_ = nullptr;
      return on_message(message.error());
    }
    if (!message->has_value()) return;
    on_message(std::move(**message));
  }
}

void ControlStream::send(const protocol::Message& message) {
  if (!is_open() || finishing_) return;
  queue(protocol::encode(message));
  if (unsent_bytes_ > kMaxUnsentBytes) {  // posted, as the caller may be iterating over its connections
    asio::post(stream_.get_executor(),
               [self = shared_from_this()] { self->end(Fault::handshake_abandoned, "the client does not read"); });
  }
}

bool ControlStream::send_data(const protocol::Data& data) {
  if (!is_open() || finishing_ || unsent_bytes_ >= kMaxUnsentData) return false;
  queue(protocol::encode(data));
  return true;
}

// Small messages that wait are joined: a TLS record and a system call for each would cost more than the copy.
void ControlStream::queue(std::vector<uint8_t> bytes) {
  unsent_bytes_ += bytes.size();
  if (outgoing_.size() > 1 && outgoing_.back().size() + bytes.size() <= kMaxTogether) {
    outgoing_.back().insert(outgoing_.back().end(), bytes.begin(), bytes.end());
    return;
  }
  outgoing_.push_back(std::move(bytes));
  if (outgoing_.size() == 1) write();
}

void ControlStream::write() {
  asio::async_write(stream_, asio::buffer(outgoing_.front()),
                    [self = shared_from_this()](asio::error_code error, size_t bytes) {
                      if (error) return self->end(Fault::handshake_abandoned, error.message());
                      self->outgoing_.pop_front();
                      self->unsent_bytes_ -= bytes;
                      if (!self->outgoing_.empty()) return self->write();
                      if (self->finishing_) self->all_written();
                    });
}

void ControlStream::finish() {
  on_message_ = nullptr;
  on_end_ = nullptr;
  finishing_ = true;
  if (outgoing_.empty()) all_written();
}

// Closing the socket while bytes of the client are unread would reset the connection, and the client could lose our
// last messages.
void ControlStream::all_written() {
  if (peer_ended_) return close();
  stream_.async_shutdown([self = shared_from_this()](asio::error_code) {
    asio::error_code ignored;
    self->stream_.lowest_layer().shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
  });
}

void ControlStream::close() {
  on_message_ = nullptr;
  on_end_ = nullptr;
  asio::error_code ignored;
  stream_.lowest_layer().close(ignored);
}

void ControlStream::end(Fault fault, const std::string& why) {
  const OnEnd on_end = std::exchange(on_end_, nullptr);
  close();
  if (on_end) on_end(fault, why);
}

ClientCertificate ControlStream::certificate() { return certificate_of(stream_.native_handle()); }

Result<protocol::SealSecrets> ControlStream::seal_secrets(SessionId session, protocol::CipherId cipher) {
  return protocol::export_secrets(stream_.native_handle(), session, cipher);
}

Result<protocol::Secret> ControlStream::resumption_secret(SessionId session) {
  return protocol::export_resumption_secret(stream_.native_handle(), session);
}

Result<protocol::Secret> ControlStream::resumption_proof(SessionId session, const protocol::Secret& secret) {
  return protocol::resumption_proof(stream_.native_handle(), session, secret);
}

}  // namespace gnomon::daemon
