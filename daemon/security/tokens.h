// Tenants' tokens. The server keeps their SHA-256 alone: what is in the configuration lets nobody in.
//
// A plain hash is enough, without the salt and the deliberate slowness that passwords need: a token is 256 random bits,
// so that there is no list of likely ones to try, and whoever could invert SHA-256 on it could guess it as well.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace gnomon::daemon {

using TokenHash = std::array<uint8_t, 32>;

std::string make_token();  // 64 hexadecimal digits, from the kernel's generator

TokenHash hash_of(std::string_view token);

std::string to_hex(const TokenHash& hash);
std::optional<TokenHash> parse_token_hash(std::string_view hex);  // 64 hexadecimal digits

// Whether `shown` is among `allowed`. How long that takes says nothing of either.
bool is_among(const TokenHash& shown, std::span<const TokenHash> allowed);

}  // namespace gnomon::daemon
