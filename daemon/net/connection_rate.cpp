#include "daemon/net/connection_rate.h"

#include <algorithm>

namespace gnomon::daemon {

ConnectionRate::Network ConnectionRate::network_of(const asio::ip::address& address) {
  const auto wide =
      address.is_v6() ? address.to_v6() : asio::ip::make_address_v6(asio::ip::v4_mapped, address.to_v4());
  const auto bytes = wide.to_bytes();
  Network network{};
  // The last 8 bytes of an IPv4-mapped IPv6 address (RFC 4291, 2.5.5.2) are 0000:ffff and the IPv4 address. No global
  // unicast network begins with 0000:ffff, so that the two kinds do not collide.
  const size_t first = wide.is_v4_mapped() ? 8 : 0;
  std::copy_n(bytes.begin() + first, network.size(), network.begin());
  return network;
}

double ConnectionRate::left(const Account& account, TimePoint now) const {
  return std::min(at_once_, account.left + per_second_ * to_seconds(now - account.counted));
}

bool ConnectionRate::admit(const asio::ip::address& address, TimePoint now) {
  const Network network = network_of(address);
  if (saved_.size() >= kMaxAddresses && !saved_.contains(network)) make_room(now);
  Account& account = saved_.try_emplace(network, Account{at_once_, now}).first->second;
  account = {left(account, now), now};
  if (account.left < 1) return false;
  account.left -= 1;
  return true;
}

void ConnectionRate::make_room(TimePoint now) {
  std::erase_if(saved_, [&](const auto& entry) { return left(entry.second, now) >= at_once_; });
  if (saved_.size() >= kMaxAddresses) saved_.clear();
}

}  // namespace gnomon::daemon
