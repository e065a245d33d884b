// Text that others have chosen, made safe for a log, a terminal or a JSON document.
#pragma once

#include <string>
#include <string_view>

namespace gnomon {

// Writes as \uXXXX what would move a cursor, break a line or turn the direction of writing: control characters (C0, DEL
// and C1), line and paragraph separators and bidirectional controls. A byte that is not UTF-8 becomes \ufffd, as an old
// terminal takes 0x80 to 0x9f alone for controls. Everything else stays as it is, and so do characters in `kept`.
std::string without_controls(std::string_view text, std::string_view kept = {});

}  // namespace gnomon
