// Field sections of HTTP/3 (QPACK, RFC 9204) without a dynamic table. Pure.
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace gnomon::daemon::quic {

using Fields = std::map<std::string, std::string>;

// Of a request: nullopt if the bytes are no field section, or have more fields than kMostFields or a longer one than
// kLongestField. Of a field that comes more often the first counts.
std::optional<Fields> decode_fields(std::span<const uint8_t> section);
inline constexpr size_t kMostFields = 64;
inline constexpr size_t kLongestField = 4096;

std::vector<uint8_t> encode_fields(const std::vector<std::pair<std::string, std::string>>& fields);

}  // namespace gnomon::daemon::quic
