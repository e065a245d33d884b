#include "daemon/net/proxy_header.h"

#include <algorithm>

namespace gnomon::daemon {
namespace {

constexpr std::array<uint8_t, 12> kSignature{0x0d, 0x0a, 0x0d, 0x0a, 0x00, 0x0d,
                                             0x0a, 0x51, 0x55, 0x49, 0x54, 0x0a};
constexpr std::array<uint8_t, 6> kSignatureOfVersion1{'P', 'R', 'O', 'X', 'Y', ' '};
constexpr uint8_t kLocal = 0x20, kProxied = 0x21;  // version 2 and the command
constexpr uint8_t kUnspecified = 0x00, kTcp4 = 0x11, kTcp6 = 0x21;

// Both addresses, the client's first, then both ports.
constexpr size_t bytes_of(size_t address_bytes) { return 2 * address_bytes + 4; }

template <class Address>
Result<std::optional<asio::ip::address>> first_address(std::span<const uint8_t> rest) {
  typename Address::bytes_type bytes;
  if (rest.size() < bytes_of(bytes.size())) return Error{"a PROXY header without room for its addresses"};
  std::copy_n(rest.begin(), bytes.size(), bytes.begin());
  return std::optional<asio::ip::address>(Address(bytes));
}

}  // namespace

bool is_proxy_start(std::span<const uint8_t> first) {
  const auto begins_with = [&](const auto& signature) {
    return first.size() >= signature.size() && std::equal(signature.begin(), signature.end(), first.begin());
  };
  return begins_with(kSignature) || begins_with(kSignatureOfVersion1);
}

Result<size_t> proxy_rest_bytes(ProxyStart start) {
  if (!std::equal(kSignature.begin(), kSignature.end(), start.begin()))
    return Error{"no PROXY header of version 2"};
  const size_t rest = size_t{start[14]} << 8 | start[15];
  if (rest > kMaxProxyRestBytes) return Error{"a PROXY header of " + std::to_string(rest) + " bytes"};
  return rest;
}

Result<std::optional<asio::ip::address>> client_of_proxy(ProxyStart start, std::span<const uint8_t> rest) {
  const uint8_t command = start[12], family = start[13];
  if (command == kLocal) return std::optional<asio::ip::address>();
  if (command != kProxied) return Error{"a PROXY header of another version, or with an unknown command"};
  switch (family) {
    case kUnspecified: return std::optional<asio::ip::address>();
    case kTcp4: return first_address<asio::ip::address_v4>(rest);
    case kTcp6: return first_address<asio::ip::address_v6>(rest);
    default: return Error{"a PROXY header that is not of TCP"};
  }
}

}  // namespace gnomon::daemon
