#include "protocol/pin.h"

#include <openssl/evp.h>
#include <openssl/x509.h>

#include <charconv>

namespace gnomon::protocol {
namespace {

constexpr std::string_view kPrefix = "sha256:";

}  // namespace

Pin pin_of(const x509_st* certificate) {
  Pin pin{};
  X509_digest(certificate, EVP_sha256(), pin.data(), nullptr);
  return pin;
}

std::string to_string(const Pin& pin) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string text(kPrefix);
  for (const uint8_t byte : pin) text.append({kDigits[byte >> 4], kDigits[byte & 15]});
  return text;
}

Result<Pin> parse_pin(std::string_view text) {
  const Error malformed{std::string(text).append(": no fingerprint; allowed: sha256: and 64 hexadecimal digits")};
  if (!text.starts_with(kPrefix)) return malformed;
  std::string digits(text.substr(kPrefix.size()));
  std::erase(digits, ':');
  Pin pin{};
  if (digits.size() != 2 * pin.size()) return malformed;
  for (size_t i = 0; i < pin.size(); ++i) {
    const char* const first = digits.data() + 2 * i;
    const auto [end, error] = std::from_chars(first, first + 2, pin[i], 16);
    if (error != std::errc{} || end != first + 2) return malformed;
  }
  return pin;
}

}  // namespace gnomon::protocol
