// The fingerprint of a certificate, for clients that are told in advance which one their server has: SHA-256 of its DER
// encoding, what `openssl x509 -noout -fingerprint -sha256` shows.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "common/result.h"

struct x509_st;

namespace gnomon::protocol {

using Pin = std::array<uint8_t, 32>;

Pin pin_of(const x509_st* certificate);

std::string to_string(const Pin& pin);  // "sha256:" and 64 hexadecimal digits

// The same; digits may be of either case and have colons between them. Error: what is allowed.
Result<Pin> parse_pin(std::string_view text);

}  // namespace gnomon::protocol
