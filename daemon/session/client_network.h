// Who counts as one client address: a single IPv4 address, or the /64 of an IPv6 address, which is what one host or one
// home has. Every limit by address counts these.
#pragma once

#include <array>
#include <asio/ip/address.hpp>
#include <compare>
#include <cstdint>

namespace gnomon::daemon {

// A plain value.
struct ClientNetwork {
  std::array<uint8_t, 8> bytes{};
  friend auto operator<=>(const ClientNetwork&, const ClientNetwork&) = default;
};

// An IPv4 address and the IPv6 address that maps it are the same network.
ClientNetwork network_of(const asio::ip::address& address);

}  // namespace gnomon::daemon
