#include "client/net/arrival_stamp.h"

#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>

#include <cerrno>
#include <cstring>

namespace gnomon::client {
namespace {

constexpr Nanoseconds kBelievable = std::chrono::seconds(2);

Nanoseconds since_epoch(const timespec& time) {
  return std::chrono::seconds(time.tv_sec) + Nanoseconds(time.tv_nsec);
}

// The kernel stamps with CLOCK_REALTIME: only the distance from now is used, and only if it is plausible.
TimePoint arrival_of(const timespec& stamp) {
  timespec calendar{};
  clock_gettime(CLOCK_REALTIME, &calendar);
  const TimePoint now = Clock::now();
  const Nanoseconds ago = since_epoch(calendar) - since_epoch(stamp);
  return ago >= Nanoseconds{} && ago < kBelievable ? now - ago : now;
}

}  // namespace

void stamp_arrivals(int socket) {
  const int on = 1;
  setsockopt(socket, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
}

Stamped receive_stamped(int socket, std::span<uint8_t> into) {
  iovec buffer{into.data(), into.size()};
  alignas(cmsghdr) char control[CMSG_SPACE(sizeof(timespec))];
  msghdr message{};
  message.msg_iov = &buffer;
  message.msg_iovlen = 1;
  message.msg_control = control;
  message.msg_controllen = sizeof control;
  const ssize_t count = recvmsg(socket, &message, MSG_DONTWAIT);
  Stamped got;
  got.nothing = count < 0 && (errno == EAGAIN || errno == EWOULDBLOCK);
  if (count <= 0) return got;
  got.bytes = static_cast<size_t>(count);
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET || c->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec stamp;
    std::memcpy(&stamp, CMSG_DATA(c), sizeof stamp);
    got.arrived = arrival_of(stamp);
    return got;
  }
  got.arrived = Clock::now();
  return got;
}

}  // namespace gnomon::client
