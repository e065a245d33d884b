// A header of the PROXY protocol, version 2, as a proxy sends it for a client.
#pragma once

#include <asio/ip/address.hpp>
#include <cstdint>
#include <string>
#include <vector>

namespace gnomon::daemon {

inline std::vector<uint8_t> proxy_bytes(const std::string& client) {
  std::vector<uint8_t> header{0x0d, 0x0a, 0x0d, 0x0a, 0x00, 0x0d, 0x0a, 0x51, 0x55, 0x49, 0x54, 0x0a, 0x21};
  const auto address = asio::ip::make_address(client);
  const auto add_twice = [&](const auto& bytes) {
    header.insert(header.end(), {static_cast<uint8_t>(bytes.size() == 4 ? 0x11 : 0x21), 0,
                                 static_cast<uint8_t>(2 * bytes.size() + 4)});
    header.insert(header.end(), bytes.begin(), bytes.end());
    header.insert(header.end(), bytes.size(), 0x7f);  // the proxy's own
  };
  if (address.is_v4()) add_twice(address.to_v4().to_bytes());
  if (address.is_v6()) add_twice(address.to_v6().to_bytes());
  header.insert(header.end(), {0x30, 0x39, 0x1d, 0xb0});  // ports
  return header;
}

}  // namespace gnomon::daemon
