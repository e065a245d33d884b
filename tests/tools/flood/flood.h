// A flood of datagrams that should not be answered, from several addresses, at a given rate, on a thread of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "tests/unit/daemon/net/test_client.h"

namespace gnomon::tests {

using Datagrams = std::vector<std::vector<uint8_t>>;

// Junk of all kinds: noise, valid headers of sessions that do not exist, truncated and too long datagrams.
Datagrams strangers_junk();

// The junk of an attacker that has listened to another's session: replays of its datagrams, and forgeries of its next
// ones, damaged in different places. `client` has sent the original datagrams when this returns.
Datagrams listeners_junk(daemon::TestClient& client);

// Sends to a port of this machine until it is destroyed.
class Flood {
 public:
  // `per_second`: datagrams; 0: as many as possible.
  Flood(uint16_t port, Datagrams junk, double per_second);
  ~Flood() { stop(); }
  void stop();

  // Datagrams so far. Every datagram that comes back counts as a reply.
  uint64_t sent() const { return sent_; }
  uint64_t replies() const { return replies_; }

 private:
  void run(uint16_t port, const Datagrams& junk, double per_second);

  std::atomic<bool> stopping_{false};
  std::atomic<uint64_t> sent_{0}, replies_{0};
  std::thread thread_;
};

}  // namespace gnomon::tests
