#include "daemon/net/data_socket.h"

#include <netinet/in.h>
#include <netinet/udp.h>

#include <cerrno>
#include <cstring>

#include "common/within_memory.h"
#include "daemon/service/supervisor.h"

namespace gnomon::daemon {
namespace {

// Room for a burst of camera updates from every client and for some large frames. It is no error if the kernel grants
// less.
constexpr int kSocketBufferBytes = 4 << 20;
// Batches received before other work of the thread gets its turn, so that a flood does not stop the sending.
constexpr int kBatchesInARow = 8;

// Limits of one buffer that the kernel cuts into datagrams: 64 segments, and an IP packet's length in all.
constexpr size_t kMaxSegments = 64;
constexpr size_t kMaxSegmentedBytes = 65000;

// How many of the datagrams, from the first, can be sent as one buffer: all have one length, except that the last may
// be shorter.
size_t run_of_segments(std::span<const std::vector<uint8_t>> datagrams) {
  const size_t size = datagrams[0].size();
  size_t run = 1, bytes = size;
  while (run < std::min(datagrams.size(), kMaxSegments) && datagrams[run - 1].size() == size &&
         datagrams[run].size() <= size && bytes + datagrams[run].size() <= kMaxSegmentedBytes) {
    bytes += datagrams[run++].size();
  }
  return run;
}

// The control message that carries the length of the segments (UDP_SEGMENT).
struct SegmentSize {
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(uint16_t))> bytes{};

  void attach(msghdr& message, size_t size) {
    message.msg_control = bytes.data();
    message.msg_controllen = bytes.size();
    cmsghdr* header = CMSG_FIRSTHDR(&message);
    header->cmsg_level = SOL_UDP;
    header->cmsg_type = UDP_SEGMENT;
    header->cmsg_len = CMSG_LEN(sizeof(uint16_t));
    const auto segment = static_cast<uint16_t>(size);
    std::memcpy(CMSG_DATA(header), &segment, sizeof segment);
  }
};

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
    error = asio::error::address_in_use;  // the service manager's socket is bound to another address
  }
  if (!error) made->socket_.non_blocking(true, error);
  if (error) {
    return Error{"server.data_port: UDP " + local.address().to_string() + " port " + std::to_string(local.port()) +
                 ": " + error.message()};
  }
  asio::error_code ignored;
  made->socket_.set_option(asio::socket_base::receive_buffer_size(kSocketBufferBytes), ignored);
  made->socket_.set_option(asio::socket_base::send_buffer_size(kSocketBufferBytes), ignored);
  // Datagrams are never fragmented: each session probes which lengths its path carries (daemon/link/mtu_discovery.h).
  const int probe = local.protocol() == asio::ip::udp::v6() ? IPV6_PMTUDISC_PROBE : IP_PMTUDISC_PROBE;
  if (local.protocol() == asio::ip::udp::v6()) {
    setsockopt(made->socket_.native_handle(), IPPROTO_IPV6, IPV6_MTU_DISCOVER, &probe, sizeof probe);
  } else {
    setsockopt(made->socket_.native_handle(), IPPROTO_IP, IP_MTU_DISCOVER, &probe, sizeof probe);
  }
  const int whole = 0;  // no segmentation by default; the call tests whether the kernel knows the option
  made->segments_ = setsockopt(made->socket_.native_handle(), SOL_UDP, UDP_SEGMENT, &whole, sizeof whole) == 0;
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
  until_memory_suffices([this] {
    socket_.async_wait(asio::ip::udp::socket::wait_read, [this](const asio::error_code& error) {
      if (error == asio::error::operation_aborted) return;
      for (int i = 0; i < kBatchesInARow && receive_batch() == kBatch; ++i) {
      }
      if (socket_.is_open()) wait();
    });
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
  if (got <= 0) return 0;  // no datagram waits, or the call has cleared a pending error of the socket
  for (size_t i = 0; i < static_cast<size_t>(got); ++i) {
    from[i].resize(messages[i].msg_hdr.msg_namelen);
    if (from[i].port() == 0) continue;  // nobody can be answered there
    done_or_dropped("a datagram",
                    [&] { on_datagram_(std::span(buffers_[i]).first(messages[i].msg_len), from[i]); });
  }
  return static_cast<size_t>(got);
}

size_t DataSocket::send(std::span<const std::vector<uint8_t>> datagrams, const asio::ip::udp::endpoint& to,
                        asio::error_code& error) {
  error.clear();
  size_t sent = 0;
  while (sent < datagrams.size() && !error) {
    const auto batch = datagrams.subspan(sent, std::min(kBatch, datagrams.size() - sent));
    size_t took = send_batch(batch, to, error);
    if (error && error != asio::error::message_size && segments_ && run_of_segments(batch) > 1) {
      // Perhaps the route's network device cannot cut a buffer into datagrams (EIO, EINVAL). If it takes them one by one,
      // they go so from now on; else the error says nothing of it, as that of a firewall or of one client's address.
      error.clear();
      segments_ = false;
      took = send_batch(batch, to, error);
      if (took == 0) segments_ = true;
    }
    if (took == 0) break;
    sent += took;
  }
  return sent;
}

size_t DataSocket::send_batch(std::span<const std::vector<uint8_t>> datagrams, const asio::ip::udp::endpoint& to,
                              asio::error_code& error) {
  asio::ip::udp::endpoint target = to;  // sendmmsg takes a non-const pointer
  std::array<mmsghdr, kBatch> messages{};
  std::array<iovec, kBatch> buffers;
  std::array<SegmentSize, kBatch> sizes;
  std::array<size_t, kBatch> first{};  // index of each message's first datagram
  unsigned count = 0;
  for (size_t i = 0; i < datagrams.size(); ++count) {
    const size_t run = segments_ ? run_of_segments(datagrams.subspan(i)) : 1;
    msghdr& header = messages[count].msg_hdr;
    header.msg_name = target.data();
    header.msg_namelen = static_cast<socklen_t>(target.size());
    header.msg_iov = &buffers[i];
    header.msg_iovlen = run;
    if (run > 1) sizes[count].attach(header, datagrams[i].size());
    first[count] = i;
    for (const size_t end = i + run; i < end; ++i) {
      buffers[i] = {const_cast<uint8_t*>(datagrams[i].data()), datagrams[i].size()};
    }
  }
  int took = 0;
  do took = sendmmsg(socket_.native_handle(), messages.data(), count, MSG_DONTWAIT);
  while (took < 0 && errno == EINTR);
  if (took < 0 && errno != EAGAIN && errno != EWOULDBLOCK) error = {errno, asio::error::get_system_category()};
  if (took <= 0) return 0;
  return static_cast<unsigned>(took) == count ? datagrams.size() : first[static_cast<size_t>(took)];
}

}  // namespace gnomon::daemon
