// How many connections an address may make: some at once, then so many a second. A TLS handshake costs a server more
// than a client, so that those who make nothing but handshakes are turned away before the first byte of one.
//
// IPv6 addresses count by their /64, which is what one host or one home has. One thread.
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

  // False: too many from there lately.
  bool admit(const asio::ip::address& address, TimePoint now);

  // Addresses remembered; beyond it those are forgotten that have made no connection for long, or else all.
  static constexpr size_t kMaxAddresses = 16'384;
  size_t size() const { return saved_.size(); }

 private:
  using Network = std::array<uint8_t, 8>;
  struct Account {
    double left = 0;
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
