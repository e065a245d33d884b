#include "daemon/data_socket.h"

#include <netinet/in.h>

#include <cerrno>

#include "daemon/supervisor.h"

namespace gnomon::daemon {
namespace {

// Room for a burst of every client's camera and for some large frames. The kernel may grant less: no error.
constexpr int kSocketBufferBytes = 4 << 20;
// Batches taken before other work of the thread gets its turn, so that a flood does not stop the sending.
constexpr int kBatchesInARow = 8;

}  // namespace

Result<std::unique_ptr<DataSocket>> DataSocket::open(asio::io_context& io, const asio::ip::udp::endpoint& local) {
  std::unique_ptr<DataSocket> made(new DataSocket(io));
  asio::error_code error;
  if (const auto given = supervisor::take_socket(supervisor::SocketKind::datagram, local.port())) {
    made->socket_.assign(local.protocol(), *given, error);
  } else {
    made->socket_.open(local.protocol(), error);
    if (!error) made->socket_.bind(local, error);
  }
  if (!error && local.port() != 0 && made->socket_.local_endpoint(error) != local && !error) {
    error = asio::error::address_in_use;  // given to us, but open at another address
  }
  if (!error) made->socket_.non_blocking(true, error);
  if (error) {
    return Error{"server.data_port: UDP " + local.address().to_string() + " port " + std::to_string(local.port()) +
                 ": " + error.message()};
  }
  asio::error_code ignored;
  made->socket_.set_option(asio::socket_base::receive_buffer_size(kSocketBufferBytes), ignored);
  made->socket_.set_option(asio::socket_base::send_buffer_size(kSocketBufferBytes), ignored);
  // No datagram is cut into fragments: which lengths pass is for the sessions to find out (daemon/link/path_mtu.h).
  const int probe = local.protocol() == asio::ip::udp::v6() ? IPV6_PMTUDISC_PROBE : IP_PMTUDISC_PROBE;
  if (local.protocol() == asio::ip::udp::v6()) {
    setsockopt(made->socket_.native_handle(), IPPROTO_IPV6, IPV6_MTU_DISCOVER, &probe, sizeof probe);
  } else {
    setsockopt(made->socket_.native_handle(), IPPROTO_IP, IP_MTU_DISCOVER, &probe, sizeof probe);
  }
  made->port_ = made->socket_.local_endpoint().port();
  return made;
}

void DataSocket::start(OnDatagram on_datagram) {
  on_datagram_ = std::move(on_datagram);
  wait();
}

void DataSocket::close() {
  asio::error_code ignored;
  socket_.close(ignored);
}

void DataSocket::wait() {
  socket_.async_wait(asio::ip::udp::socket::wait_read, [this](const asio::error_code& error) {
    if (error == asio::error::operation_aborted) return;
    for (int i = 0; i < kBatchesInARow && receive_batch() == kBatch; ++i) {
    }
    if (socket_.is_open()) wait();
  });
}

size_t DataSocket::receive_batch() {
  std::array<mmsghdr, kBatch> messages{};
  std::array<iovec, kBatch> buffers;
  std::array<asio::ip::udp::endpoint, kBatch> from;
  for (size_t i = 0; i < kBatch; ++i) {
    buffers[i] = {buffers_[i].data(), buffers_[i].size()};
    messages[i].msg_hdr.msg_iov = &buffers[i];
    messages[i].msg_hdr.msg_iovlen = 1;
    messages[i].msg_hdr.msg_name = from[i].data();
    messages[i].msg_hdr.msg_namelen = static_cast<socklen_t>(from[i].capacity());
  }
  const int got = recvmmsg(socket_.native_handle(), messages.data(), kBatch, MSG_DONTWAIT, nullptr);
  if (got <= 0) return 0;  // nothing waits; an error of one datagram has been taken from the socket by this
  for (size_t i = 0; i < static_cast<size_t>(got); ++i) {
    from[i].resize(messages[i].msg_hdr.msg_namelen);
    on_datagram_(std::span(buffers_[i]).first(messages[i].msg_len), from[i]);
  }
  return static_cast<size_t>(got);
}

size_t DataSocket::send(std::span<const std::vector<uint8_t>> datagrams, const asio::ip::udp::endpoint& to,
                        asio::error_code& error) {
  error.clear();
  asio::ip::udp::endpoint target = to;  // sendmmsg takes a pointer that is not const
  size_t sent = 0;
  while (sent < datagrams.size()) {
    std::array<mmsghdr, kBatch> messages{};
    std::array<iovec, kBatch> buffers;
    const size_t count = std::min(kBatch, datagrams.size() - sent);
    for (size_t i = 0; i < count; ++i) {
      const std::vector<uint8_t>& bytes = datagrams[sent + i];
      buffers[i] = {const_cast<uint8_t*>(bytes.data()), bytes.size()};
      messages[i].msg_hdr.msg_iov = &buffers[i];
      messages[i].msg_hdr.msg_iovlen = 1;
      messages[i].msg_hdr.msg_name = target.data();
      messages[i].msg_hdr.msg_namelen = static_cast<socklen_t>(target.size());
    }
    const int took = sendmmsg(socket_.native_handle(), messages.data(), static_cast<unsigned>(count), MSG_DONTWAIT);
    if (took < 0 && errno == EINTR) continue;
    if (took < 0) {
      if (errno != EAGAIN && errno != EWOULDBLOCK) error = {errno, asio::error::get_system_category()};
      return sent;
    }
    sent += static_cast<size_t>(took);
  }
  return sent;
}

}  // namespace gnomon::daemon
