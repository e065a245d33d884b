#include "common/printable.h"

#include <cstdint>
#include <cstdio>
#include <optional>

namespace gnomon {
namespace {

constexpr uint32_t kReplacement = 0xfffd;

struct Character {
  uint32_t code;
  size_t bytes;
};

// The first character of a text that is not empty; nullopt if its bytes are not UTF-8 (RFC 3629, section 4).
std::optional<Character> first_of(std::string_view text) {
  const auto byte = [&](size_t i) { return static_cast<uint8_t>(text[i]); };
  const uint8_t lead = byte(0);
  if (lead < 0x80) return Character{lead, 1};
  const size_t bytes = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || text.size() < bytes) return std::nullopt;
  uint32_t code = lead & (0xffu >> (bytes + 1));
  for (size_t i = 1; i < bytes; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return std::nullopt;
    code = code << 6 | (byte(i) & 0x3fu);
  }
  constexpr uint32_t kLeast[] = {0, 0, 0x80, 0x800, 0x10000};
  const bool surrogate = code >= 0xd800 && code <= 0xdfff;
  if (code < kLeast[bytes] || code > 0x10ffff || surrogate) return std::nullopt;
  return Character{code, bytes};
}

bool is_control(uint32_t code) {
  const bool c0_or_c1 = code < 0x20 || (code >= 0x7f && code < 0xa0);
  const bool separator = code == 0x2028 || code == 0x2029;
  const bool bidirectional = code == 0x061c || code == 0x200e || code == 0x200f ||
                             (code >= 0x202a && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
  return c0_or_c1 || separator || bidirectional || code == 0xfeff;
}

}  // namespace

std::string without_controls(std::string_view text, std::string_view kept) {
  std::string out;
  out.reserve(text.size());
  while (!text.empty()) {
    const auto character = first_of(text);
    const size_t bytes = character ? character->bytes : 1;
    const bool keep = kept.find(text.front()) != std::string_view::npos;
    if (character && (keep || !is_control(character->code))) {
      out += text.substr(0, bytes);
    } else {
      char escaped[8];
      std::snprintf(escaped, sizeof escaped, "\\u%04x", character ? character->code : kReplacement);
      out += escaped;
    }
    text.remove_prefix(bytes);
  }
  return out;
}

}  // namespace gnomon
