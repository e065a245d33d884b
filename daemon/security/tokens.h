// The tenants' tokens. The server stores only their SHA-256: knowing the configuration is not enough to connect.
//
// A plain hash is enough, without the salt and the deliberate slowness that passwords need: a token is 256 random bits,
// so there is no list of likely tokens to try, and finding one from its hash is as hard as guessing it.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace gnomon::daemon {

using TokenHash = std::array<uint8_t, 32>;

// Begins with kTokenMark, so that one in the place of its hash is noticed; then 64 hexadecimal digits from the kernel's
// generator.
std::string make_token();
inline constexpr std::string_view kTokenMark = "gnomon_";

TokenHash hash_of(std::string_view token);

std::string to_hex(const TokenHash& hash);
std::optional<TokenHash> parse_token_hash(std::string_view hex);  // 64 hexadecimal digits

// Whether `shown` is among `allowed`, in a time that does not depend on the hashes' contents.
bool is_among(const TokenHash& shown, std::span<const TokenHash> allowed);

}  // namespace gnomon::daemon
