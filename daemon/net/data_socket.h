// A UDP socket that receives and sends datagrams in batches: hundreds of clients at ninety frames a second make tens
// of thousands of datagrams a second, and a system call for each would cost more than everything else done with them.
#pragma once

#include <sys/socket.h>

#include <array>
#include <asio/io_context.hpp>
#include <asio/ip/udp.hpp>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "common/result.h"
#include "protocol/datagram.h"

namespace gnomon::daemon {

// Used on one thread, that of the io_context, which outlives the socket.
class DataSocket {
 public:
  // Takes the service manager's socket for this port if there is one, else opens one; port 0 stands for any free port.
  static Result<std::unique_ptr<DataSocket>> open(asio::io_context& io, const asio::ip::udp::endpoint& local);

  uint16_t port() const { return port_; }
  asio::ip::udp::endpoint local() const { return socket_.local_endpoint(); }

  // A longer datagram is truncated to this, which is as long as QUIC's may be (daemon/quic/connection.cpp); ours are
  // shorter.
  static constexpr size_t kLongestBytes = 1500;
  // Called for each datagram, which is valid during the call.
  using OnDatagram = std::function<void(std::span<const uint8_t>, const asio::ip::udp::endpoint& from)>;
  void start(OnDatagram on_datagram);
  void close();

  // Returns how many of the datagrams the kernel took, from the first. If fewer than all, its buffer is full or `error`
  // is set.
  size_t send(std::span<const std::vector<uint8_t>> datagrams, const asio::ip::udp::endpoint& to,
              asio::error_code& error);

  static constexpr size_t kBatch = 64;

  // Whether the kernel cuts long buffers into datagrams (UDP generic segmentation offload).
  bool segments() const { return segments_; }
  void do_not_segment() { segments_ = false; }

 private:
  explicit DataSocket(asio::io_context& io) : socket_(io) {}
  void wait();
  size_t receive_batch();
  size_t send_batch(std::span<const std::vector<uint8_t>> datagrams, const asio::ip::udp::endpoint& to,
                    asio::error_code& error);

  asio::ip::udp::socket socket_;
  uint16_t port_ = 0;
  bool segments_ = false;
  OnDatagram on_datagram_;
  std::array<std::array<uint8_t, kLongestBytes>, kBatch> buffers_;
};

}  // namespace gnomon::daemon
