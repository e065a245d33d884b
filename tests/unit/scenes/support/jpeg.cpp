#include "tests/unit/scenes/support/jpeg.h"

#include <cstddef>

namespace gnomon::scenes::testing {
namespace {

using Bytes = std::vector<uint8_t>;

void append(Bytes& out, const Bytes& more) { out.insert(out.end(), more.begin(), more.end()); }

// A segment: its marker, its length, its content.
void append_segment(Bytes& out, uint8_t marker, const Bytes& content) {
  const std::size_t length = content.size() + 2;
  append(out, {0xff, marker, static_cast<uint8_t>(length >> 8), static_cast<uint8_t>(length)});
  append(out, content);
}

Bytes quantisation_table() {
  Bytes table(65, 1);
  table[0] = 0;
  return table;
}

// One code of one bit, for the symbol 0. `kind`: 0 for DC, 0x10 for AC.
Bytes huffman_table(uint8_t kind) {
  Bytes table(18, 0);
  table[0] = kind;
  table[1] = 1;
  return table;
}

uint8_t high(uint16_t v) { return static_cast<uint8_t>(v >> 8); }
uint8_t low(uint16_t v) { return static_cast<uint8_t>(v); }

}  // namespace

Bytes jpeg(uint16_t width, uint16_t height, uint32_t scans) {
  Bytes out = {0xff, 0xd8};
  append_segment(out, 0xdb, quantisation_table());
  append_segment(out, 0xc2, {8, high(height), low(height), high(width), low(width), 1, 1, 0x11, 0});
  append_segment(out, 0xc4, huffman_table(0));
  append_segment(out, 0xc4, huffman_table(0x10));
  // The first scan of the DC coefficients leaves one bit out, which each further one brings.
  for (uint32_t i = 0; i < scans; ++i) {
    append_segment(out, 0xda, {1, 1, 0, 0, 0, static_cast<uint8_t>(i == 0 ? 0x01 : 0x10)});
  }
  append(out, {0xff, 0xd9});
  return out;
}

}  // namespace gnomon::scenes::testing
