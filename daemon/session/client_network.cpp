#include "daemon/session/client_network.h"

#include <algorithm>

namespace gnomon::daemon {

ClientNetwork network_of(const asio::ip::address& address) {
  const auto wide =
      address.is_v6() ? address.to_v6() : asio::ip::make_address_v6(asio::ip::v4_mapped, address.to_v4());
  const auto bytes = wide.to_bytes();
  ClientNetwork network;
  // The last 8 bytes of an IPv4-mapped IPv6 address (RFC 4291, 2.5.5.2) are 0000:ffff and the IPv4 address. No global
  // unicast network begins with 0000:ffff, so that the two kinds do not collide.
  const size_t first = wide.is_v4_mapped() ? 8 : 0;
  std::copy_n(bytes.begin() + first, network.bytes.size(), network.bytes.begin());
  return network;
}

}  // namespace gnomon::daemon
