// Connections of the proxies that the configuration names: each begins with a PROXY header, which is read before anything
// of the client is.
#pragma once

#include <asio/ip/network_v4.hpp>
#include <asio/ip/network_v6.hpp>
#include <asio/ip/tcp.hpp>
#include <functional>
#include <string>
#include <vector>

#include "common/clock.h"
#include "common/result.h"

namespace gnomon::daemon {

// The addresses and networks of server.proxies. An IPv4 address and the IPv6 address that maps it are the same. Constant
// after its construction.
class ProxyAddresses {
 public:
  explicit ProxyAddresses(
      const std::vector<std::string>& addresses);  // numeric ones, and networks as in 10.0.0.0/8
  bool contains(const asio::ip::address& address) const;

 private:
  std::vector<asio::ip::network_v4> networks_v4_;  // an address is a network of its own
  std::vector<asio::ip::network_v6> networks_v6_;
};

// Who is at the other end of the proxy; the proxy's own address where it speaks for itself. Error: what is wrong with the
// header, or that it did not come in time.
using Greeted = std::function<void(asio::ip::tcp::socket, const Result<asio::ip::address>&)>;

// Reads the header and nothing of what follows it. `greeted` is called once, on the socket's executor, unless that is
// stopped before.
void read_proxy_greeting(asio::ip::tcp::socket socket, Nanoseconds patience, Greeted greeted);

}  // namespace gnomon::daemon
