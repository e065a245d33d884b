// URIs by which glTF refers to bytes. Internal to scenes/gltf/.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"

namespace gnomon::scenes::gltf {

std::string percent_decoded(const std::string& text);

bool is_data_uri(const std::string& uri);

// Decodes a data URI (RFC 2397) of any media type, base64 or percent-encoded. Error: the data cannot be decoded.
Result<std::vector<uint8_t>> decode_data_uri(const std::string& uri);

}  // namespace gnomon::scenes::gltf
