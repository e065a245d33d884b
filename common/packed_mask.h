// The format in which masks leave the GPU: a class for each tile of each light, and words for the mixed tiles only.
//
// A bit matters ("care") where a segment was traced: elsewhere the light does not shine on the surface that the pixel
// shows, and shading multiplies the bit by zero. Bits that do not matter are filled in so that the mask compresses
// well, by this rule, which gives the same words for the same input everywhere:
//
//   tile      all bits that matter are 0: dark; all are 1: lit; none matters: free; else: mixed
//   free      takes the class of the last tile before it, in its light, that is dark or lit; dark if there is none
//   mixed     a bit that does not matter takes the value of the nearest one above it in its column that does, else
//             of the nearest below; a column in which none matters is copied from the nearest to the left in which one
//             does, else from the nearest to the right
#pragma once

#include <cassert>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "common/tile_mask.h"

namespace gnomon {

enum class PackedClass : uint8_t { dark = 0, lit = 1, mixed = 2, free = 3 };

inline constexpr uint32_t kClassesInWord = 16;

// A borrowed view of a packed mask; its owner (a frame lease, a PackedMask) states how long it is valid.
struct PackedMaskView {
  TileGrid grid;
  std::span<const uint32_t> classes;  // two bits for each word of the TileMaskView, the first in the lowest bits
  std::span<const uint64_t> mixed;    // the words of mixed tiles, filled, in that same order

  static constexpr size_t class_words(const TileGrid& grid) {
    return (grid.word_count() + kClassesInWord - 1) / kClassesInWord;
  }
  PackedClass class_of(size_t word) const {
    return static_cast<PackedClass>(classes[word / kClassesInWord] >> (word % kClassesInWord * 2) & 3);
  }
  size_t bytes() const { return classes.size_bytes() + mixed.size_bytes(); }
};

// Calls uniform(index, lit) or mixed(index, word) for every word in order. Free tiles are reported as uniform, with the
// class that they take.
template <class Uniform, class Mixed>
void for_each_word(const PackedMaskView& packed, Uniform uniform, Mixed mixed) {
  size_t next = 0, index = 0;
  for (uint32_t light = 0; light < packed.grid.planes; ++light) {
    bool lit = false;
    for (uint32_t tile = 0; tile < packed.grid.tile_count(); ++tile, ++index) {
      const PackedClass of_tile = packed.class_of(index);
      if (of_tile == PackedClass::mixed) {
        mixed(index, packed.mixed[next++]);
        continue;
      }
      if (of_tile != PackedClass::free) lit = of_tile == PackedClass::lit;
      uniform(index, lit);
    }
  }
  assert(next == packed.mixed.size());
}

// Writes all words of the mask. Precondition: words.size() == packed.grid.word_count().
void unpack(const PackedMaskView& packed, std::span<uint64_t> words);
std::vector<uint64_t> unpacked(const PackedMaskView& packed);

// The word of a mixed tile, filled by the rule above. `care` has a 1 for each bit that matters.
uint64_t filled(uint64_t lit, uint64_t care);

// Packs a mask on the CPU and owns the result.
class PackedMask {
 public:
  PackedMask() = default;
  // `care`: words of the same grid as `mask`, with a 1 for each bit that matters.
  PackedMask(const TileMaskView& mask, std::span<const uint64_t> care);

  PackedMaskView view() const { return {grid_, classes_, mixed_}; }

 private:
  TileGrid grid_;
  std::vector<uint32_t> classes_;
  std::vector<uint64_t> mixed_;
};

}  // namespace gnomon
