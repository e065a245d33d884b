// Addresses written as HOST:PORT.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"

namespace gnomon::client {

struct Address {
  std::string host;  // a name or a numeric address, without brackets
  uint16_t port = 0;
};

// Accepts "host:7600", "127.0.0.1:7600" or "[::1]:7600".
Result<Address> parse_address(std::string_view text);

std::string to_string(const Address& address);

}  // namespace gnomon::client
