// QUIC's integers of variable length (RFC 9000, 16). Pure.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace gnomon::daemon::quic {

// Appends a value below 2^62.
inline void append_varint(std::vector<uint8_t>& out, uint64_t value) {
  const int width = value < 1u << 6 ? 0 : value < 1u << 14 ? 1 : value < 1u << 30 ? 2 : 3;
  const int bytes = 1 << width;
  for (int i = bytes - 1; i >= 0; --i) {
    const auto byte = static_cast<uint8_t>(value >> (8 * i));
    out.push_back(i == bytes - 1 ? static_cast<uint8_t>(byte | width << 6) : byte);
  }
}

// Takes a value from the front; nullopt, and nothing is taken, if it is not complete.
inline std::optional<uint64_t> take_varint(std::span<const uint8_t>& bytes) {
  if (bytes.empty()) return std::nullopt;
  const size_t size = size_t{1} << (bytes[0] >> 6);
  if (bytes.size() < size) return std::nullopt;
  uint64_t value = bytes[0] & 0x3f;
  for (size_t i = 1; i < size; ++i) value = value << 8 | bytes[i];
  bytes = bytes.subspan(size);
  return value;
}

}  // namespace gnomon::daemon::quic
