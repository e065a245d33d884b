// A flood of datagrams that nobody should answer, from several addresses, at a rate, from a thread of its own.
#pragma once

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "tests/unit/daemon/net/test_client.h"

namespace gnomon::tests {

using Datagrams = std::vector<std::vector<uint8_t>>;

// Junk of all kinds: noise, right headers of sessions that do not exist, pieces, what is too long.
Datagrams strangers_junk();

// What somebody sends who has listened to a session of another: its datagrams once more, and ones that pretend to be
// its next, damaged in different places. `client` has sent the first ones when this returns.
Datagrams listeners_junk(daemon::TestClient& client);

// Sends to that port of this machine until it is dropped.
class Flood {
 public:
  // `per_second`: 0: as many as it can.
  Flood(uint16_t port, Datagrams junk, double per_second);
  ~Flood() { stop(); }
  void stop();

  // Until now. What came back counts as a reply, whatever it is.
  uint64_t sent() const { return sent_; }
  uint64_t replies() const { return replies_; }

 private:
  void run(uint16_t port, const Datagrams& junk, double per_second);

  std::atomic<bool> stopping_{false};
  std::atomic<uint64_t> sent_{0}, replies_{0};
  std::thread thread_;
};

}  // namespace gnomon::tests
