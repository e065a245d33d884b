// Digests and Base64 as other protocols want them. Any thread.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>

namespace gnomon::daemon {

std::array<uint8_t, 32> sha256(std::span<const uint8_t> bytes);
// For RFC 6455 alone, where it is no secret's guard.
std::array<uint8_t, 20> sha1(std::span<const uint8_t> bytes);

std::string base64(std::span<const uint8_t> bytes);

}  // namespace gnomon::daemon
