// When datagrams reached this machine, by the kernel's timestamps: a program that draws for 50 ms reads its socket
// late, which must not look like queueing on the path.
#pragma once

#include <cstdint>
#include <span>

#include "common/clock.h"

namespace gnomon::client {

// Asks the kernel for timestamps of what arrives at the UDP socket. Where it gives none, the time of reading counts.
void stamp_arrivals(int socket);

struct Stamped {
  bool nothing = false;  // no datagram was waiting
  size_t bytes = 0;      // 0: a pending error of the socket, now cleared
  TimePoint arrived{};
};

// Receives one datagram without blocking.
Stamped receive_stamped(int socket, std::span<uint8_t> into);

}  // namespace gnomon::client
