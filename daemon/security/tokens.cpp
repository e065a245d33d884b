#include "daemon/security/tokens.h"

#include <openssl/crypto.h>
#include <openssl/evp.h>
#include <openssl/rand.h>

#include <charconv>
#include <cstdlib>

namespace gnomon::daemon {

std::string make_token() {
  TokenHash bytes;
  if (RAND_priv_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1) std::abort();
  return std::string(kTokenMark) + to_hex(bytes);
}

TokenHash hash_of(std::string_view token) {
  TokenHash hash{};
  if (EVP_Digest(token.data(), token.size(), hash.data(), nullptr, EVP_sha256(), nullptr) != 1) std::abort();
  return hash;
}

std::string to_hex(const TokenHash& hash) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string hex;
  for (const uint8_t byte : hash) hex.append({kDigits[byte >> 4], kDigits[byte & 15]});
  return hex;
}

std::optional<TokenHash> parse_token_hash(std::string_view hex) {
  TokenHash hash{};
  if (hex.size() != 2 * hash.size()) return std::nullopt;
  for (size_t i = 0; i < hash.size(); ++i) {
    const char* const first = hex.data() + 2 * i;
    const auto [end, error] = std::from_chars(first, first + 2, hash[i], 16);
    if (error != std::errc{} || end != first + 2) return std::nullopt;
  }
  return hash;
}

bool is_among(const TokenHash& shown, std::span<const TokenHash> allowed) {
  bool found = false;
  for (const TokenHash& hash : allowed) found |= CRYPTO_memcmp(shown.data(), hash.data(), hash.size()) == 0;
  return found;
}

}  // namespace gnomon::daemon
