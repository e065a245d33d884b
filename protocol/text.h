// Text on the wire: UTF-8 without control characters, so that it can go into a log line or JSON as it is.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace gnomon::protocol {

bool is_wire_text(std::string_view text);

// `text` made valid for the wire: every invalid byte becomes '?', and the text is cut between two characters to at most
// `max_bytes`.
std::string wire_text(std::string_view text, size_t max_bytes);

}  // namespace gnomon::protocol
