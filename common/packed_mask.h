// How masks leave the GPU: a class for each tile of each light, and the words of those tiles alone that need one.
//
// A bit matters ("care") where a tracer was asked: elsewhere the light shines on nothing that the pixel shows, and
// shading multiplies the bit by zero. What does not matter is filled in so that the mask becomes cheap to code, by
// this rule, which makes the same words of the same input everywhere:
//
//   tile      all bits that matter are 0: dark; all are 1: lit; none matters: free; else: mixed
//   free      takes the class of the last tile before it, in its light, that is dark or lit; dark if there is none
//   mixed     a bit that does not matter takes the value of the nearest one above it in its column that does, else
//             of the nearest below; a column in which none matters is that of the nearest to the left, else right
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

// Borrowed; valid as long as their owner says.
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

// Calls uniform(index, lit) or mixed(index, word) for every word in order, free tiles as what they take.
template <class Uniform, class Mixed>
void for_each_word(const PackedMaskView& packed, Uniform uniform, Mixed mixed) {
  size_t next = 0, index = 0;
  for (uint32_t light = 0; light < packed.grid.lights; ++light) {
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

// Into grid.word_count() words.
void unpack(const PackedMaskView& packed, std::span<uint64_t> words);
std::vector<uint64_t> unpacked(const PackedMaskView& packed);

// The word of a mixed tile.
uint64_t filled(uint64_t lit, uint64_t care);

// The same on the CPU, owning what it makes.
class PackedMask {
 public:
  PackedMask() = default;
  // `care`: of the same grid as `mask`.
  PackedMask(const TileMaskView& mask, std::span<const uint64_t> care);

  PackedMaskView view() const { return {grid_, classes_, mixed_}; }

 private:
  TileGrid grid_;
  std::vector<uint32_t> classes_;
  std::vector<uint64_t> mixed_;
};

}  // namespace gnomon
