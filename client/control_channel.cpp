#include "client/control_channel.h"

#include <array>
#include <asio/connect.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/write.hpp>
#include <deque>
#include <utility>

namespace gnomon::client {

using asio::ip::tcp;

// Shared with the handlers under way, so that dropping the channel leaves them something to look at: `closed`.
struct ControlChannel::State : std::enable_shared_from_this<State> {
  State(Loop& loop, const Address& address, Events handlers)
      : server(address), events(std::move(handlers)), resolver(loop.context()), socket(loop.context()) {}

  Address server;
  Events events;
  tcp::resolver resolver;
  tcp::socket socket;
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
    asio::async_connect(socket, found, [self = shared_from_this()](const asio::error_code& error, const auto&) {
      if (self->closed) return;
      if (error) return self->fail(std::string("cannot reach ") + to_string(self->server), error);
      asio::error_code ignored;
      self->socket.set_option(tcp::no_delay(true), ignored);
      self->read();
      self->events.connected();
    });
  }

  void read() {
    socket.async_read_some(asio::buffer(received),
                           [self = shared_from_this()](const asio::error_code& error, size_t count) {
                             if (self->closed) return;
                             if (error) return self->fail("the server closed the connection", error);
                             self->reader.feed(std::span(self->received).first(count));
                             if (self->deliver()) self->read();
                           });
  }

  // False when nothing more is to be read.
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
    asio::async_write(socket, asio::buffer(to_write.front()),
                      [self = shared_from_this()](const asio::error_code& error, size_t) {
                        if (self->closed) return;
                        if (error) return self->fail("the server closed the connection", error);
                        self->to_write.pop_front();
                        if (!self->to_write.empty()) self->write_first();
                      });
  }

  void fail(const std::string& what, const asio::error_code& error) {
    shut();
    const bool plain_end = !error || error == asio::error::eof;
    events.failed(Error{plain_end ? what : what + ": " + error.message()});
  }

  void shut() {
    closed = true;
    asio::error_code ignored;
    resolver.cancel();
    socket.shutdown(tcp::socket::shutdown_both, ignored);
    socket.close(ignored);
  }
};

ControlChannel::ControlChannel(Loop& loop, const Address& server, Events events)
    : state_(std::make_shared<State>(loop, server, std::move(events))) {
  state_->start();
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
  if (state_->to_write.empty() && state_->socket.is_open()) {
    asio::error_code ignored;
    state_->socket.non_blocking(true, ignored);
    state_->socket.write_some(asio::buffer(protocol::encode(protocol::Bye{reason})), ignored);
  }
  state_->shut();
}

std::string ControlChannel::server_ip() const {
  asio::error_code ignored;
  return state_->socket.remote_endpoint(ignored).address().to_string(ignored);
}

}  // namespace gnomon::client
