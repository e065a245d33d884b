#include "client/net/address.h"

#include <charconv>

namespace gnomon::client {

Result<Address> parse_address(std::string_view text) {
  const Error malformed{std::string("'").append(text) + "' is no HOST:PORT, such as localhost:7600 or [::1]:7600"};
  const size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return malformed;
  std::string_view host = text.substr(0, colon);
  const std::string_view digits = text.substr(colon + 1);
  if (host.size() >= 2 && host.front() == '[' && host.back() == ']') {
    host = host.substr(1, host.size() - 2);
  } else if (host.find(':') != std::string_view::npos) {
    return malformed;  // an IPv6 address without brackets could end anywhere
  }
  Address address{std::string(host), 0};
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), address.port);
  if (host.empty() || error != std::errc{} || end != digits.data() + digits.size() || address.port == 0) {
    return malformed;
  }
  return address;
}

std::string to_string(const Address& address) {
  const bool v6 = address.host.find(':') != std::string::npos;
  return (v6 ? std::string("[") + address.host + "]" : address.host) + ":" + std::to_string(address.port);
}

}  // namespace gnomon::client
