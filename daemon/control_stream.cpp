#include "daemon/control_stream.h"

#include <asio/buffer.hpp>
#include <asio/post.hpp>
#include <asio/write.hpp>
#include <utility>

namespace gnomon::daemon {

ControlStream::ControlStream(asio::ip::tcp::socket socket, size_t max_message_bytes)
    : socket_(std::move(socket)), reader_(max_message_bytes) {
  asio::error_code ignored;
  socket_.set_option(asio::ip::tcp::no_delay(true), ignored);
  peer_ = socket_.remote_endpoint(ignored).address();
}

void ControlStream::listen(OnMessage on_message, OnEnd on_end) {
  on_message_ = std::move(on_message);
  on_end_ = std::move(on_end);
}

void ControlStream::start() { read(); }

void ControlStream::read() {
  socket_.async_read_some(
      asio::buffer(incoming_), [self = shared_from_this()](asio::error_code error, size_t bytes) {
        if (error == asio::error::eof && self->finishing_ && !self->outgoing_.empty()) {
          self->peer_ended_ = true;  // its sending side alone, perhaps: what we are writing may still be read
          return;
        }
        if (error) return self->end(error == asio::error::eof ? "closed by the client" : error.message());
        if (!self->finishing_) {
          self->reader_.feed(std::span(self->incoming_).first(bytes));
          self->deliver_messages();
        }
        if (self->socket_.is_open()) self->read();
      });
}

void ControlStream::deliver_messages() {
  while (!finishing_ && on_message_) {
    auto message = reader_.next();
    const OnMessage on_message = on_message_;  // the callee may end the connection, and with it the member
    if (!message) {
      on_message_ = nullptr;
      return on_message(message.error());
    }
    if (!message->has_value()) return;
    on_message(std::move(**message));
  }
}

void ControlStream::send(const protocol::Message& message) {
  if (!socket_.is_open() || finishing_) return;
  outgoing_.push_back(protocol::encode(message));
  unsent_bytes_ += outgoing_.back().size();
  if (unsent_bytes_ > kMaxUnsentBytes) {  // later, not now: the caller may be going through its connections
    asio::post(socket_.get_executor(), [self = shared_from_this()] { self->end("the client does not read"); });
    return;
  }
  if (outgoing_.size() == 1) write();
}

void ControlStream::write() {
  asio::async_write(socket_, asio::buffer(outgoing_.front()),
                    [self = shared_from_this()](asio::error_code error, size_t bytes) {
                      if (error) return self->end(error.message());
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

// Closing now, with bytes of the client unread, would reset the connection and could take our last words with it.
void ControlStream::all_written() {
  asio::error_code ignored;
  socket_.shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
  if (peer_ended_) close();
}

void ControlStream::close() {
  on_message_ = nullptr;
  on_end_ = nullptr;
  asio::error_code ignored;
  socket_.close(ignored);
}

void ControlStream::end(const std::string& why) {
  const OnEnd on_end = std::exchange(on_end_, nullptr);
  close();
  if (on_end) on_end(why);
}

}  // namespace gnomon::daemon
