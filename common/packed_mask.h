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

#include <algorithm>
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

// True if the last tile before `word` in its plane that is dark or lit is lit: what a free tile there takes.
bool lit_before(const PackedMaskView& packed, size_t word);

// Calls uniform(index, count, lit), for a run of dark or lit words, or mixed(index, word) for the words [first, end) of one
// plane, in order. Free tiles are reported as uniform, with the class that they take. `next` is the index of the first mixed
// word from `first` on; returns that of the first from `end` on.
template <class Uniform, class Mixed>
size_t for_words_between(const PackedMaskView& packed, size_t first, size_t end, size_t next, Uniform uniform,
                         Mixed mixed) {
  constexpr uint32_t kAllDark = 0, kAllLit = 0x55555555, kAllFree = 0xffffffff;
  bool lit = lit_before(packed, first);
  for (size_t index = first; index < end;) {
    if (index % kClassesInWord == 0 && end - index >= kClassesInWord) {  // most of a picture
      const uint32_t of_run = packed.classes[index / kClassesInWord];
      if (of_run == kAllDark || of_run == kAllLit || of_run == kAllFree) {
        if (of_run != kAllFree) lit = of_run == kAllLit;
        uniform(index, kClassesInWord, lit);
        index += kClassesInWord;
        continue;
      }
    }
    const size_t last = std::min(end, (index / kClassesInWord + 1) * kClassesInWord);
    for (; index < last; ++index) {
      const PackedClass of_tile = packed.class_of(index);
      if (of_tile == PackedClass::mixed) {
        mixed(index, packed.mixed[next++]);
        continue;
      }
      if (of_tile != PackedClass::free) lit = of_tile == PackedClass::lit;
      uniform(index, 1, lit);
    }
  }
  return next;
}

// The same for every word of the frame.
template <class Uniform, class Mixed>
void for_each_word(const PackedMaskView& packed, Uniform uniform, Mixed mixed) {
  const size_t tiles = packed.grid.tile_count();
  size_t next = 0;
  for (size_t plane = 0; plane < packed.grid.planes; ++plane) {
    next = for_words_between(packed, plane * tiles, (plane + 1) * tiles, next, uniform, mixed);
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
