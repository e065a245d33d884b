// Limits the connections of each address: `at_once` in a burst, then `per_second`. A TLS handshake costs a server more
// than a client, so that clients that make nothing but handshakes are turned away before the first byte of one.
//
// One thread at a time.
#pragma once

#include <cstdint>
#include <map>

#include "common/clock.h"
#include "daemon/session/client_network.h"

namespace gnomon::daemon {

class ConnectionRate {
 public:
  ConnectionRate(uint32_t at_once, uint32_t per_second) : at_once_(at_once), per_second_(per_second) {}

  // Returns false if the network has exceeded its rate.
  bool admit(const ClientNetwork& network, TimePoint now);

  // Most networks that are remembered. Beyond it, those are forgotten that have most of their allowance left, a share of
  // all at a time: a flood of fresh addresses forgets its own, and none that has spent what it may.
  static constexpr size_t kMaxNetworks = 16'384;
  size_t size() const { return saved_.size(); }

 private:
  struct Account {
    double left = 0;  // connections
    TimePoint counted;
  };
  double left(const Account& account, TimePoint now) const;
  void make_room(TimePoint now);

  double at_once_;
  double per_second_;
  std::map<ClientNetwork, Account> saved_;
};

}  // namespace gnomon::daemon
