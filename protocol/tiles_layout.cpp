// The layout of tiles_lz4: for each light of the range two bits a tile, then the mixed tiles' 8 bytes each, then the
// edge tiles' 4 bytes each. An edge tile is one whose rows are each a run of ones that touches the left or the right
// side, as along most shadow edges; there are exactly 16 such rows, so that a row takes 4 bits.
#include <array>
#include <bit>
#include <cstring>

#include "protocol/slice_layout.h"

namespace gnomon::protocol {
namespace {

// Row n < 9 has its n lowest bits set; row n >= 9 its 16 - n highest.
constexpr std::array<uint8_t, 16> kEdgeRows = {0x00, 0x01, 0x03, 0x07, 0x0f, 0x1f, 0x3f, 0x7f,
                                               0xff, 0xfe, 0xfc, 0xf8, 0xf0, 0xe0, 0xc0, 0x80};
constexpr uint8_t kNoEdge = 0xff;

constexpr auto kEdgeNumbers = [] {
  std::array<uint8_t, 256> numbers;
  numbers.fill(kNoEdge);
  for (uint8_t n = 0; n < 16; ++n) numbers[kEdgeRows[n]] = n;
  return numbers;
}();

// Two rows from two numbers.
constexpr auto kEdgePairs = [] {
  std::array<uint16_t, 256> pairs{};
  for (unsigned n = 0; n < 256; ++n) pairs[n] = static_cast<uint16_t>(kEdgeRows[n & 15] | kEdgeRows[n >> 4] << 8);
  return pairs;
}();

bool is_edge(uint64_t word) {
  uint8_t numbers = 0;
  for (int row = 0; row < 8; ++row) numbers |= kEdgeNumbers[(word >> (row * 8)) & 0xff];
  return numbers < 16;
}

uint32_t edge_code(uint64_t word) {
  uint32_t code = 0;
  for (int row = 0; row < 8; ++row) code |= uint32_t{kEdgeNumbers[(word >> (row * 8)) & 0xff]} << (row * 4);
  return code;
}

uint64_t edge_word(uint32_t code) {
  uint64_t word = 0;
  for (int pair = 0; pair < 4; ++pair) word |= uint64_t{kEdgePairs[(code >> (pair * 8)) & 0xff]} << (pair * 16);
  return word;
}

size_t class_bytes(uint32_t tiles) { return (tiles + 3) / 4; }

// Where the three parts of a slice's plain bytes start.
struct Parts {
  size_t mixed = 0;
  size_t edges = 0;
  size_t end = 0;
};

Parts parts_of(std::span<const uint8_t> packed_classes) {
  size_t mixed = 0;
  size_t edges = 0;
  for (const uint8_t four : packed_classes) {
    const unsigned high = (four >> 1) & 0x55u;
    mixed += std::popcount(high & ~unsigned{four});
    edges += std::popcount(high & unsigned{four});
  }
  const size_t start = packed_classes.size();
  return {start, start + mixed * sizeof(uint64_t), start + mixed * sizeof(uint64_t) + edges * sizeof(uint32_t)};
}

void pack_classes(std::span<const TileClass> classes, uint8_t* out) {
  size_t i = 0;
  for (; i + 4 <= classes.size(); i += 4) {
    uint32_t four;
    std::memcpy(&four, &classes[i], sizeof four);
    *out++ = static_cast<uint8_t>(four | four >> 6 | four >> 12 | four >> 18);
  }
  if (i == classes.size()) return;
  uint8_t last = 0;
  for (size_t k = i; k < classes.size(); ++k) {
    last = static_cast<uint8_t>(last | static_cast<uint8_t>(classes[k]) << ((k - i) * 2));
  }
  *out = last;
}

// The bits of a light's last class byte beyond its last tile are 0.
bool padding_is_clear(const uint8_t* packed, uint32_t tiles) {
  return tiles % 4 == 0 || packed[tiles / 4] >> (tiles % 4 * 2) == 0;
}

template <class T>
void put(uint8_t*& at, T value) {
  std::memcpy(at, &value, sizeof value);
  at += sizeof value;
}

template <class T>
T take(const uint8_t*& at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  at += sizeof value;
  return value;
}

}  // namespace

void classify(std::span<const uint64_t> words, std::vector<TileClass>& classes) {
  classes.resize(words.size());
  for (size_t i = 0; i < words.size(); ++i) {
    const uint64_t word = words[i];
    const bool uniform = word + 1 <= 1;  // no bit set, or all of them
    classes[i] = uniform ? static_cast<TileClass>(word & 1) : is_edge(word) ? TileClass::edge : TileClass::mixed;
  }
}

bool pack_tiles(const TileMaskView& frame, std::span<const TileClass> classes, const SliceRange& range,
                std::vector<uint8_t>& plain) {
  const size_t plane_bytes = class_bytes(range.tile_count);
  const size_t all_class_bytes = plane_bytes * range.light_count;
  if (all_class_bytes > kMaxPlainBytes) return false;
  plain.resize(kMaxPlainBytes);
  const auto first_word = [&](uint32_t l) {
    return size_t{range.first_light + l} * frame.grid.tile_count() + range.first_tile;
  };
  for (uint32_t l = 0; l < range.light_count; ++l) {
    pack_classes(classes.subspan(first_word(l), range.tile_count), plain.data() + l * plane_bytes);
  }
  const Parts parts = parts_of(std::span(plain).first(all_class_bytes));
  if (parts.end > kMaxPlainBytes) return false;
  uint8_t* mixed = plain.data() + parts.mixed;
  uint8_t* edges = plain.data() + parts.edges;
  for (uint32_t l = 0; l < range.light_count; ++l) {
    const uint8_t* packed = plain.data() + l * plane_bytes;
    const uint64_t* words = frame.words.data() + first_word(l);
    for (size_t byte = 0; byte < plane_bytes; ++byte) {
      if ((packed[byte] & 0xaa) == 0) continue;
      for (uint32_t k = 0; k < 4; ++k) {
        const unsigned tile_class = (packed[byte] >> (k * 2)) & 3;
        if (tile_class == unsigned(TileClass::mixed)) put(mixed, words[byte * 4 + k]);
        if (tile_class == unsigned(TileClass::edge)) put(edges, edge_code(words[byte * 4 + k]));
      }
    }
  }
  plain.resize(parts.end);
  return true;
}

bool unpack_tiles(std::span<const uint8_t> plain, const SliceRange& range, const TileGrid& grid,
                  std::span<uint64_t> words) {
  const size_t plane_bytes = class_bytes(range.tile_count);
  const size_t all_class_bytes = plane_bytes * range.light_count;
  if (all_class_bytes > plain.size()) return false;
  const Parts parts = parts_of(plain.first(all_class_bytes));
  if (parts.end != plain.size()) return false;
  const uint8_t* mixed = plain.data() + parts.mixed;
  const uint8_t* edges = plain.data() + parts.edges;
  for (uint32_t l = 0; l < range.light_count; ++l) {
    const uint8_t* packed = plain.data() + l * plane_bytes;
    if (!padding_is_clear(packed, range.tile_count)) return false;
    uint64_t* out = words.data() + size_t{range.first_light + l} * grid.tile_count() + range.first_tile;
    for (uint32_t tile = 0; tile < range.tile_count; ++tile) {
      switch (static_cast<TileClass>((packed[tile / 4] >> (tile % 4 * 2)) & 3)) {
        case TileClass::dark: out[tile] = 0; break;
        case TileClass::lit: out[tile] = ~uint64_t{0}; break;
        case TileClass::mixed: out[tile] = take<uint64_t>(mixed); break;
        case TileClass::edge: out[tile] = edge_word(take<uint32_t>(edges)); break;
      }
    }
  }
  return true;
}

}  // namespace gnomon::protocol
