// Limits the connections of each address: `at_once` in a burst, then `per_second`. A TLS handshake costs a server more
// than a client, so that clients that make nothing but handshakes are turned away before the first byte of one.
//
// IPv6 addresses count by their /64, which is what one host or one home has. One thread at a time.
#pragma once

#include <asio/ip/address.hpp>

#include <array>
#include <cstdint>
#include <map>

#include "common/clock.h"

namespace gnomon::daemon {

class ConnectionRate {
 public:
  ConnectionRate(uint32_t at_once, uint32_t per_second) : at_once_(at_once), per_second_(per_second) {}

  // Returns false if the address has exceeded its rate.
  bool admit(const asio::ip::address& address, TimePoint now);

  // Most addresses that are remembered. Beyond it, addresses with a full allowance are forgotten; if there are none,
  // all are.
  static constexpr size_t kMaxAddresses = 16'384;
  size_t size() const { return saved_.size(); }

 private:
  using Network = std::array<uint8_t, 8>;
  struct Account {
    double left = 0;  // connections
    TimePoint counted;
  };
  static Network network_of(const asio::ip::address& address);
  double left(const Account& account, TimePoint now) const;
  void make_room(TimePoint now);

  double at_once_;
  double per_second_;
  std::map<Network, Account> saved_;
};

}  // namespace gnomon::daemon
