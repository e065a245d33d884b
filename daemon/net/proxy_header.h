// The header of the PROXY protocol, version 2, with which a proxy begins each connection that it passes on: it says whose
// connection it is. https://www.haproxy.org/download/2.6/doc/proxy-protocol.txt, section 2.2. Pure.
#pragma once

#include <array>
#include <asio/ip/address.hpp>
#include <cstdint>
#include <optional>
#include <span>

#include "common/result.h"

namespace gnomon::daemon {

// The part of constant length: signature, version and command, family, length of the rest.
inline constexpr size_t kProxyStartBytes = 16;
using ProxyStart = std::span<const uint8_t, kProxyStartBytes>;

// Addresses and what proxies may add to them. A longer header is refused.
inline constexpr size_t kMaxProxyRestBytes = 2048;

// Whether these first bytes of a connection are a header's of version 1 or 2, and no client's. They may be fewer than
// kProxyStartBytes.
bool is_proxy_start(std::span<const uint8_t> first);

// How many bytes follow the start. Error if it is not the start of a header of version 2.
Result<size_t> proxy_rest_bytes(ProxyStart start);

// The client's address. nullopt: the proxy speaks for itself, or does not say for whom. Error if the header is malformed
// or is of something else than TCP. Precondition: `rest` has the length that proxy_rest_bytes() has said.
Result<std::optional<asio::ip::address>> client_of_proxy(ProxyStart start, std::span<const uint8_t> rest);

}  // namespace gnomon::daemon
