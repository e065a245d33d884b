// One direction of a TCP connection through a Link. TCP repairs its losses: bytes that the link drops are sent again
// after kRepair, and until then nothing more is read, so that the sender is slowed down.
#pragma once

#include <array>
#include <asio/ip/tcp.hpp>
#include <asio/write.hpp>
#include <memory>
#include <vector>

#include "tests/tools/netsim/delay_line.h"
#include "tests/tools/netsim/link.h"

namespace gnomon::netsim {

// Keeps itself, the sockets and the link's owner alive until the connection ends.
class StreamPump : public std::enable_shared_from_this<StreamPump> {
 public:
  using Socket = std::shared_ptr<asio::ip::tcp::socket>;

  static void start(Socket from, Socket to, std::shared_ptr<void> owner, Link& link, DelayLine& line) {
    std::shared_ptr<StreamPump> pump(new StreamPump(std::move(from), std::move(to), std::move(owner), link, line));
    pump->read();
  }

 private:
  static constexpr auto kRepair = std::chrono::milliseconds(20);

  StreamPump(Socket from, Socket to, std::shared_ptr<void> owner, Link& link, DelayLine& line)
      : owner_(std::move(owner)), from_(std::move(from)), to_(std::move(to)), link_(link), line_(line) {}

  void read() {
    from_->async_read_some(asio::buffer(buffer_),
                           [self = shared_from_this()](const asio::error_code& error, size_t count) {
                             if (error) return self->end();
                             self->send(count);
                           });
  }

  void send(size_t count) {
    const TimePoint now = Clock::now();
    const Fate fate = link_.send(count, now);
    if (fate.copies == 0) return line_.at(now + kRepair, [self = shared_from_this(), count] { self->send(count); });
    last_ = std::max(last_, fate.at[0]);
    line_.at(last_, [self = shared_from_this(), bytes = std::vector(buffer_.begin(), buffer_.begin() + count)] {
      self->write(bytes);
    });
    read();
  }

  void write(const std::vector<uint8_t>& bytes) {
    waiting_.insert(waiting_.end(), bytes.begin(), bytes.end());
    if (writing_.empty()) write_waiting();
  }

  void write_waiting() {
    writing_.swap(waiting_);
    waiting_.clear();
    asio::async_write(*to_, asio::buffer(writing_),
                      [self = shared_from_this()](const asio::error_code& error, size_t) {
                        self->writing_.clear();
                        if (error) return self->end();
                        if (!self->waiting_.empty())
                          self->write_waiting();
                        else if (self->ended_)
                          self->shut();
                      });
  }

  // Bytes that are under way still arrive, and then the end of the stream.
  void end() {
    line_.at(std::max(last_, Clock::now()), [self = shared_from_this()] {
      self->ended_ = true;
      if (self->writing_.empty()) self->shut();
    });
  }

  void shut() {
    asio::error_code ignored;
    to_->shutdown(asio::ip::tcp::socket::shutdown_send, ignored);
  }

  std::shared_ptr<void> owner_;
  Socket from_, to_;
  Link& link_;
  DelayLine& line_;
  TimePoint last_{};
  bool ended_ = false;
  std::array<uint8_t, 1400> buffer_{};
  std::vector<uint8_t> waiting_, writing_;
};

}  // namespace gnomon::netsim
