#include "common/packed_mask.h"

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

void unpack(const PackedMaskView& packed, std::span<uint64_t> words) {
  assert(words.size() == packed.grid.word_count());
  for_each_word(
      packed, [&](size_t i, bool lit) { words[i] = lit ? ~uint64_t{0} : 0; },
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
