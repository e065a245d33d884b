#include "client/net/control_channel.h"

#include <openssl/err.h>
#include <openssl/ssl.h>
#include <openssl/x509_vfy.h>

#include <array>
#include <asio/connect.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/post.hpp>
#include <asio/ssl/context.hpp>
#include <asio/ssl/error.hpp>
#include <asio/ssl/stream.hpp>
#include <asio/write.hpp>
#include <deque>
#include <utility>

#include "protocol/seal_exporter.h"

namespace gnomon::client {
namespace {

using asio::ip::tcp;

// OpenSSL's objection to the server's certificate, in words for a person, and what can be done about it; empty if it
// accepts it.
std::string complaint(SSL* tls) {
  const long found = SSL_get_verify_result(tls);
  const std::string shown = shown_pin(tls);
  switch (found) {
    case X509_V_OK: return "";
    case X509_V_ERR_CERT_UNTRUSTED: return "it is not the one expected; the server shows " + shown;
    case X509_V_ERR_DEPTH_ZERO_SELF_SIGNED_CERT:
    case X509_V_ERR_SELF_SIGNED_CERT_IN_CHAIN:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT:
    case X509_V_ERR_UNABLE_TO_GET_ISSUER_CERT_LOCALLY:
    case X509_V_ERR_UNABLE_TO_VERIFY_LEAF_SIGNATURE:
      return std::string(X509_verify_cert_error_string(found)) +
             "; name who has signed it (--ca), or, if the server's operator confirms that it is this one, the "
             "certificate itself (--pin " +
             shown + ")";
    default: return X509_verify_cert_error_string(found);
  }
}

// What is likely where TLS begins with something else, as at the admin server's port.
std::string advice(const asio::error_code& error) {
  if (error.category() != asio::error::get_ssl_category()) return "";
  switch (ERR_GET_REASON(static_cast<unsigned long>(error.value()))) {
    case SSL_R_WRONG_VERSION_NUMBER:
    case SSL_R_TLSV1_ALERT_NO_APPLICATION_PROTOCOL:
      return "; this is not the port for clients, which is server.control_port (7600, if nobody has changed it; "
             "admin.port is another one)";
    default: return "";
  }
}

}  // namespace

// Shared with pending handlers, so that they can check `closed` after the channel's destruction.
struct ControlChannel::State : std::enable_shared_from_this<State> {
  State(Loop& loop, const Address& address, std::string name, std::unique_ptr<asio::ssl::context> context,
        Events handlers)
      : server(address),
        server_name(std::move(name)),
        events(std::move(handlers)),
        tls(std::move(context)),
        resolver(loop.context()),
        stream(loop.context(), *tls) {}

  Address server;
  std::string server_name;  // said in TLS; if empty, none is
  Events events;
  std::unique_ptr<asio::ssl::context> tls;
  tcp::resolver resolver;
  asio::ssl::stream<tcp::socket> stream;
  protocol::MessageReader reader;
  std::array<uint8_t, 16384> received{};
  std::deque<std::vector<uint8_t>> to_write;  // the first is being written
  bool closed = false;

  void start() {
    resolver.async_resolve(server.host, std::to_string(server.port),
                           [self = shared_from_this()](const asio::error_code& error, const auto& found) {
                             if (self->closed) return;
                             if (error) return self->fail("cannot look up " + self->server.host, error);
                             self->connect(found);
                           });
  }

  void connect(const tcp::resolver::results_type& found) {
    asio::async_connect(
        stream.next_layer(), found, [self = shared_from_this()](const asio::error_code& error, const auto&) {
          if (self->closed) return;
          if (error) {
            return self->fail(std::string("cannot reach ") + to_string(self->server), error,
                              error == asio::error::connection_refused ? "; no gnomond listens there" : "");
          }
          self->shake_hands();
        });
  }

  void shake_hands() {
    asio::error_code ignored;
    stream.next_layer().set_option(tcp::no_delay(true), ignored);
    if (!server_name.empty()) SSL_set_tlsext_host_name(stream.native_handle(), server_name.c_str());
    stream.async_handshake(
        asio::ssl::stream_base::client, [self = shared_from_this()](const asio::error_code& error) {
          if (self->closed) return;
          const std::string distrust = complaint(self->stream.native_handle());
          if (error && !distrust.empty()) {
            return self->fail("the certificate of " + to_string(self->server) + " is refused: " + distrust, {});
          }
          if (error) return self->fail("no TLS with " + to_string(self->server), error, advice(error));
          self->read();
          self->events.connected();
        });
  }

  void read() {
    stream.async_read_some(asio::buffer(received),
                           [self = shared_from_this()](const asio::error_code& error, size_t count) {
                             if (self->closed) return;
                             if (error) return self->fail("the server closed the connection", error);
                             self->reader.feed(std::span(self->received).first(count));
                             if (self->deliver()) self->read();
                           });
  }

  // Delivers the messages that are complete. False if nothing more is to be read.
  bool deliver() {
    while (!closed) {
      auto next = reader.next();
      if (!next) {
        fail("the server sent a malformed message: " + next.error().message, {});
        return false;
      }
      if (!next->has_value()) return true;
      events.message(std::move(**next));
    }
    return false;
  }

  void write_first() {
    asio::async_write(stream, asio::buffer(to_write.front()),
                      [self = shared_from_this()](const asio::error_code& error, size_t) {
                        if (self->closed) return;
                        if (error) return self->fail("the server closed the connection", error);
                        self->to_write.pop_front();
                        if (!self->to_write.empty()) self->write_first();
                      });
  }

  void fail(const std::string& what, const asio::error_code& error, const std::string& hint = {}) {
    shut();
    const bool plain_end = !error || error == asio::error::eof || error == asio::ssl::error::stream_truncated;
    events.failed(Error{(plain_end ? what : what + ": " + error.message()) + hint});
  }

  void shut() {
    closed = true;
    asio::error_code ignored;
    resolver.cancel();
    stream.lowest_layer().shutdown(tcp::socket::shutdown_both, ignored);
    stream.lowest_layer().close(ignored);
  }
};

ControlChannel::ControlChannel(Loop& loop, const Address& server, const Trust& trust, const std::string& scene,
                               Events events) {
  auto opened = open_trust(trust, server.host);
  auto context = opened ? std::move(*opened) : std::make_unique<asio::ssl::context>(asio::ssl::context::tls_client);
  state_ = std::make_shared<State>(loop, server, server_name(trust, server.host, scene), std::move(context),
                                   std::move(events));
  if (opened) {
    state_->start();
  } else {  // reported from the loop, as any failure
    asio::post(loop.context(), [state = state_, why = opened.error().message] {
      if (!state->closed) state->fail(why, {});
    });
  }
}

ControlChannel::~ControlChannel() {
  if (!state_->closed) state_->shut();
}

void ControlChannel::send(const protocol::Message& message) {
  if (state_->closed) return;
  state_->to_write.push_back(protocol::encode(message));
  if (state_->to_write.size() == 1) state_->write_first();
}

void ControlChannel::close(const std::string& reason) {
  if (state_->closed) return;
  if (state_->to_write.empty() && SSL_is_init_finished(state_->stream.native_handle())) {
    asio::error_code ignored;
    state_->stream.next_layer().non_blocking(true, ignored);
    state_->stream.write_some(asio::buffer(protocol::encode(protocol::Bye{reason})), ignored);
  }
  state_->shut();
}

std::string ControlChannel::server_ip() const {
  asio::error_code ignored;
  return state_->stream.next_layer().remote_endpoint(ignored).address().to_string();
}

Result<protocol::SealSecrets> ControlChannel::seal_secrets(SessionId session, protocol::CipherId cipher) const {
  return protocol::export_secrets(state_->stream.native_handle(), session, cipher);
}

Result<protocol::Secret> ControlChannel::resumption_secret(SessionId session) const {
  return protocol::export_resumption_secret(state_->stream.native_handle(), session);
}

Result<protocol::Secret> ControlChannel::resumption_proof(SessionId session, const protocol::Secret& secret) const {
  return protocol::resumption_proof(state_->stream.native_handle(), session, secret);
}

}  // namespace gnomon::client
