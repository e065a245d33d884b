// References of glTF to bytes elsewhere. Internal to scenes/gltf/.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "common/result.h"

namespace gnomon::scenes::gltf {

std::string percent_decoded(const std::string& text);

bool is_data_uri(const std::string& uri);

// RFC 2397, whatever media type it names: base64 or percent-encoded.
Result<std::vector<uint8_t>> decode_data_uri(const std::string& uri);

}  // namespace gnomon::scenes::gltf
