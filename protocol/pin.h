// The fingerprint of a certificate, by which a client that is given it in advance recognises its server: SHA-256 of the
// DER encoding, as `openssl x509 -noout -fingerprint -sha256` shows it.
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

// Parses the form of to_string(); digits may be of either case and separated by colons. Error: the allowed form.
Result<Pin> parse_pin(std::string_view text);

}  // namespace gnomon::protocol
