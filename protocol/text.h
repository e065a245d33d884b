// Text on the wire: UTF-8 without control characters, so that it can go into a log line or JSON as it is.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace gnomon::protocol {

bool is_wire_text(std::string_view text);

// `text` as it may be sent: every byte at fault becomes '?', and what is beyond `max_bytes` is cut off between
// two characters.
std::string wire_text(std::string_view text, size_t max_bytes);

}  // namespace gnomon::protocol
