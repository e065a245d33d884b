#include "common/packed_mask.h"

#include <algorithm>
#include <bit>

namespace gnomon {
namespace {

constexpr uint64_t kNoFirstColumn = 0xfefefefefefefefe;
constexpr uint64_t kNoFirstTwo = 0xfcfcfcfcfcfcfcfc;
constexpr uint64_t kNoFirstFour = 0xf0f0f0f0f0f0f0f0;

// Fills bits that are not known from known ones: each unknown bit takes the value of the known bit that `shift` moves
// onto it. Shifts by doubling distances, the shortest first, find the nearest known bit in logarithmically many steps.
struct Fill {
  uint64_t value, known;

  template <class Shift>
  void take(Shift shift) {
    const uint64_t from = shift(known) & ~known;
    value |= shift(value) & from;
    known |= from;
  }
};

PackedClass class_of(uint64_t lit, uint64_t care) {
  const bool any_lit = (lit & care) != 0, any_dark = (~lit & care) != 0;
  if (any_lit && any_dark) return PackedClass::mixed;
  return any_lit ? PackedClass::lit : any_dark ? PackedClass::dark : PackedClass::free;
}

}  // namespace

uint64_t filled(uint64_t lit, uint64_t care) {
  Fill fill{lit & care, care};
  for (const int rows : {1, 2, 4}) fill.take([=](uint64_t word) { return word << 8 * rows; });
  for (const int rows : {1, 2, 4}) fill.take([=](uint64_t word) { return word >> 8 * rows; });
  fill.take([](uint64_t word) { return word << 1 & kNoFirstColumn; });
  fill.take([](uint64_t word) { return word << 2 & kNoFirstTwo; });
  fill.take([](uint64_t word) { return word << 4 & kNoFirstFour; });
  fill.take([](uint64_t word) { return (word & kNoFirstColumn) >> 1; });
  fill.take([](uint64_t word) { return (word & kNoFirstTwo) >> 2; });
  fill.take([](uint64_t word) { return (word & kNoFirstFour) >> 4; });
  return fill.value;
}

bool lit_before(const PackedMaskView& packed, size_t word) {
  constexpr uint32_t kHighBits = 0xaaaaaaaa;  // of a class: 0 if the tile is dark or lit
  const size_t plane_begins = word - word % packed.grid.tile_count();
  for (size_t end = word; end > plane_begins;) {
    const size_t at = (end - 1) / kClassesInWord;  // of the class word that holds the tiles before `end`
    const size_t first = std::max(at * kClassesInWord, plane_begins);
    const auto among = static_cast<uint32_t>((uint64_t{1} << 2 * (end - at * kClassesInWord)) - 1) &
                       ~uint32_t{0} << 2 * (first - at * kClassesInWord);
    const uint32_t uniform = ~packed.classes[at] & kHighBits & among;
    if (uniform != 0) return packed.classes[at] >> (31 - std::countl_zero(uniform) - 1) & 1;
    end = first;
  }
  return false;
}

void unpack(const PackedMaskView& packed, std::span<uint64_t> words) {
  assert(words.size() == packed.grid.word_count());
  for_each_word(
      packed,
      [&](size_t first, uint32_t count, bool lit) {
        std::fill_n(words.begin() + static_cast<std::ptrdiff_t>(first), count, lit ? ~uint64_t{0} : 0);
      },
      [&](size_t i, uint64_t word) { words[i] = word; });
}

std::vector<uint64_t> unpacked(const PackedMaskView& packed) {
  std::vector<uint64_t> words(packed.grid.word_count());
  unpack(packed, words);
  return words;
}

PackedMask::PackedMask(const TileMaskView& mask, std::span<const uint64_t> care) : grid_(mask.grid) {
  assert(mask.words.size() == grid_.word_count() && care.size() == mask.words.size());
  classes_.resize(PackedMaskView::class_words(grid_));
  for (size_t i = 0; i < care.size(); ++i) {
    const PackedClass of_tile = class_of(mask.words[i], care[i]);
    classes_[i / kClassesInWord] |= static_cast<uint32_t>(of_tile) << (i % kClassesInWord * 2);
    if (of_tile == PackedClass::mixed) mixed_.push_back(filled(mask.words[i], care[i]));
  }
}

}  // namespace gnomon
