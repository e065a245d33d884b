// When datagrams reached this machine, by the kernel's stamps: a program that draws for 50 ms reads late what came in
// time, and that must not look like a queue on the way.
#pragma once

#include <cstdint>
#include <span>

#include "common/clock.h"

namespace gnomon::client {

// Asks the kernel to stamp what arrives at the UDP socket. Where it does not, the time of reading counts.
void stamp_arrivals(int socket);

struct Stamped {
  bool nothing = false;  // nothing waits
  size_t bytes = 0;      // 0: an error, taken from the socket
  TimePoint arrived{};
};

// Without waiting.
Stamped receive_stamped(int socket, std::span<uint8_t> into);

}  // namespace gnomon::client
