#include "daemon/net/control_stream.h"

#include <openssl/ssl.h>

#include <string_view>
#include <utility>

#include "protocol/seal_exporter.h"

namespace gnomon::daemon {
namespace {

bool speaks_http(const SSL* tls) {
  const unsigned char* chosen = nullptr;
  unsigned size = 0;
  SSL_get0_alpn_selected(tls, &chosen, &size);
  return std::string_view(reinterpret_cast<const char*>(chosen), size) == "http/1.1";
}

}  // namespace

ControlStream::ControlStream(asio::ip::tcp::socket socket, const asio::ip::address& client, asio::ssl::context& tls,
                             size_t max_message_bytes)
    : TlsConnection(std::move(socket), client, tls), messages_(max_message_bytes) {}

void ControlStream::listen(OnMessage on_message, OnEnd on_end) {
  on_message_ = std::move(on_message);
  on_end_ = std::move(on_end);
}

void ControlStream::on_open() {
  browser_ = browser_listener_ && speaks_http(tls());
  if (!browser_) browser_listener_ = nullptr;
  if (browser_) browser_listener_->on_open();
}

void ControlStream::on_bytes(std::span<const uint8_t> bytes) {
  if (const auto listener = browser_listener_) return listener->on_bytes(bytes);  // a copy, as it may be dropped
  messages_.feed(bytes);
  deliver_messages();
}

void ControlStream::become_websocket(std::span<const uint8_t> first, const std::string& origin) {
  origin_ = origin;
  drop_listener();
  messages_.become_websocket();
  messages_.feed(first);
  deliver_messages();
}

void ControlStream::deliver_messages() {
  while (!is_finishing() && on_message_) {
    auto message = messages_.next();
    if (auto replies = messages_.take_replies(); !replies.empty()) {
      send_bytes(std::move(replies));
      cut_off_if_it_does_not_read();
    }
    if (messages_.is_closed()) return end_later("closed by the client");  // later, as the reply is under way
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
  send_bytes(messages_.framed(protocol::encode(message)));
  cut_off_if_it_does_not_read();
}

// Later, as the caller may be iterating over its connections.
void ControlStream::cut_off_if_it_does_not_read() {
  if (unsent_bytes() > kMaxUnsentBytes) end_later("the client does not read");
}

bool ControlStream::has_room() {
  wants_room_ = unsent_bytes() >= kMaxUnsentData;
  return !wants_room_;
}

void ControlStream::send_data(const protocol::Data& data) { send_bytes(messages_.framed(protocol::encode(data))); }

void ControlStream::on_sent(size_t bytes) {
  if (const auto listener = browser_listener_) return listener->on_sent(bytes);  // a copy, as it may be dropped
  if (!wants_room_ || unsent_bytes() >= kMaxUnsentData) return;
  wants_room_ = false;
  if (const auto on_room = on_room_) on_room();  // a copy, as the callee may end the connection
}

void ControlStream::finish() {
  if (auto farewell = messages_.farewell(); !farewell.empty()) send_bytes(std::move(farewell));
  forget_callbacks();
  finish_sending();
}

void ControlStream::close() {
  forget_callbacks();
  close_socket();
}

void ControlStream::forget_callbacks() {
  on_message_ = nullptr;
  on_end_ = nullptr;
  on_room_ = nullptr;
  drop_listener();
}

void ControlStream::drop_listener() {
  if (const auto listener = std::exchange(browser_listener_, nullptr)) listener->on_end();
}

void ControlStream::on_ended(Fault fault, const std::string& why) {
  const OnEnd on_end = std::exchange(on_end_, nullptr);
  if (on_end) on_end(fault, why);
  forget_callbacks();
}

ClientCertificate ControlStream::certificate() { return certificate_of(tls()); }

Result<protocol::SealSecrets> ControlStream::seal_secrets(SessionId session, protocol::CipherId cipher) {
  return protocol::export_secrets(tls(), session, cipher);
}

Result<protocol::Secret> ControlStream::resumption_secret(SessionId session) {
  return protocol::export_resumption_secret(tls(), session);
}

Result<protocol::Secret> ControlStream::resumption_proof(SessionId session, const protocol::Secret& secret) {
  return protocol::resumption_proof(tls(), session, secret);
}

}  // namespace gnomon::daemon
