#include "daemon/net/proxy_greeting.h"

#include <algorithm>
#include <array>
#include <asio/buffer.hpp>
#include <asio/read.hpp>
#include <asio/steady_timer.hpp>
#include <memory>

#include "daemon/net/proxy_header.h"

namespace gnomon::daemon {
namespace {

using asio::ip::address;
using asio::ip::tcp;

address unmapped(const address& any) {
  const bool mapped = any.is_v6() && any.to_v6().is_v4_mapped();
  return mapped ? address(asio::ip::make_address_v4(asio::ip::v4_mapped, any.to_v6())) : any;
}

// Kept alive by its own pending operations.
class Greeting : public std::enable_shared_from_this<Greeting> {
 public:
  Greeting(tcp::socket socket, Greeted greeted)
      : socket_(std::move(socket)), greeted_(std::move(greeted)), deadline_(socket_.get_executor()) {}

  void start(Nanoseconds patience) {
    deadline_.expires_after(patience);
    deadline_.async_wait([self = shared_from_this()](asio::error_code cancelled) {
      if (!cancelled) self->give_up();
    });
    asio::async_read(socket_, asio::buffer(start_), [self = shared_from_this()](asio::error_code error, size_t) {
      if (error) return self->end(Error{"no PROXY header came"});
      self->read_rest();
    });
  }

 private:
  void read_rest() {
    const auto bytes = proxy_rest_bytes(start_);
    if (!bytes) return end(bytes.error());
    rest_.resize(*bytes);
    asio::async_read(socket_, asio::buffer(rest_), [self = shared_from_this()](asio::error_code error, size_t) {
      if (error) return self->end(Error{"only a part of a PROXY header came"});
      self->judge();
    });
  }

  void judge() {
    const auto client = client_of_proxy(start_, rest_);
    if (!client) return end(client.error());
    if (*client) return end(**client);
    asio::error_code gone;
    const address own = socket_.remote_endpoint(gone).address();
    if (gone) return end(Error{"the proxy has gone"});
    end(own);
  }

  void end(const Result<address>& client) {
    deadline_.cancel();
    greeted_(std::move(socket_), client);
  }

  // The read that is under way ends with an error, and so does the next if that one has just ended.
  void give_up() {
    asio::error_code ignored;
    socket_.close(ignored);
  }

  tcp::socket socket_;
  Greeted greeted_;
  asio::steady_timer deadline_;
  std::array<uint8_t, kProxyStartBytes> start_{};
  std::vector<uint8_t> rest_;
};

}  // namespace

ProxyAddresses::ProxyAddresses(const std::vector<std::string>& addresses) {
  for (const std::string& each : addresses) {
    const size_t slash = each.find('/');
    const address first = unmapped(asio::ip::make_address(each.substr(0, slash)));
    const int bits = slash == std::string::npos ? (first.is_v4() ? 32 : 128) : std::stoi(each.substr(slash + 1));
    if (first.is_v4()) {
      networks_v4_.emplace_back(first.to_v4(), static_cast<unsigned short>(bits));
    } else {
      networks_v6_.emplace_back(first.to_v6(), static_cast<unsigned short>(bits));
    }
  }
}

bool ProxyAddresses::contains(const address& any) const {
  const address asked = unmapped(any);
  const auto holds = [](const auto& host) {
    return [&host](const auto& network) {
      return std::decay_t<decltype(network)>(host, network.prefix_length()).network() == network.network();
    };
  };
  if (asked.is_v4()) return std::any_of(networks_v4_.begin(), networks_v4_.end(), holds(asked.to_v4()));
  return std::any_of(networks_v6_.begin(), networks_v6_.end(), holds(asked.to_v6()));
}

void read_proxy_greeting(tcp::socket socket, Nanoseconds patience, Greeted greeted) {
  std::make_shared<Greeting>(std::move(socket), std::move(greeted))->start(patience);
}

}  // namespace gnomon::daemon
