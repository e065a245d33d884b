// How both programs read values from their command lines.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "common/result.h"

namespace gnomon::client {

struct Size {
  uint16_t width = 0;
  uint16_t height = 0;
};

// "1920x1080". Both from `least` to protocol::kMaxSide.
Result<Size> parse_size(std::string_view text, uint32_t least = 1);

// The file's first line. Error: why it cannot be read, or that it is empty.
Result<std::string> read_token(const std::filesystem::path& file);

}  // namespace gnomon::client
