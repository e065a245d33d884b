// The probability of each decision of a slice: nets, statistics of the slice that correct them, and plain counts where
// a net would be wasted. Encoder and decoder run the same code. One slice at a time.
#pragma once

#include <algorithm>
#include <cstdlib>

#include "common/packed_mask.h"
#include "protocol/context/contexts.h"
#include "protocol/context/predictor.h"

namespace gnomon::protocol::context {

// The motion of a block of tiles, in pixels: its pixel (x, y) corresponds to (x + dx, y + dy) of the reference.
struct Motion {
  int dx = 0, dy = 0;
  friend bool operator==(const Motion&, const Motion&) = default;
};
inline constexpr int kMostMotion = 511;
inline constexpr Motion kAnyMotion{kMostMotion + 1, 0};  // of a block that needs none: the cheapest is coded

inline Motion median(const Motion& a, const Motion& b, const Motion& c) {
  const auto middle = [](int x, int y, int z) { return std::max(std::min(x, y), std::min(std::max(x, y), z)); };
  return {middle(a.dx, b.dx, c.dx), middle(a.dy, b.dy, c.dy)};
}

inline constexpr uint32_t kSegment = 32;  // tiles; segments end at its multiples

template <bool Referenced>
class SliceModel {
 public:
  static constexpr bool kReferenced = Referenced;
  using Windows = RowWindows<Referenced>;
  using Surroundings = TileSurroundings<Referenced>;

  SliceModel() { reset(); }

  void reset() {
    pixel_.reset();
    run_.reset();
    mixed_.reset();
    lit_.reset();
    counts_ = initial();
  }

  template <class Coder>
  bool pixel(Coder& coder, bool bit, const Windows& windows, int at) {
    const auto asked = windows.about_pixel(at);
    return pixel_.code(coder, bit, pixels_.output(asked.inputs), asked.fine, asked.coarse);
  }
  // Codes how many of a run's pixels are as those before it: `kept`, at most `length`. The pixel after them is not.
  template <class Coder>
  int run(Coder& coder, int kept, const Windows& windows, int at, int length) {
    const auto asked = windows.about_run(at, length);
    if (!run_.code(coder, kept < length, runs_.output(asked.inputs), asked.fine, asked.coarse)) return length;
    auto& breaks = counts_.breaks[windows.last(at)][static_cast<size_t>(length - 1)];
    int number = 0;
    while (number + 1 < length && !breaks[static_cast<size_t>(number)].code(coder, kept == number)) ++number;
    return number;
  }

  // Codes a tile's class and returns it: kDark, kLit or kMixed. A free tile takes the likelier of dark and lit.
  template <class Coder>
  uint8_t tile(Coder& coder, PackedClass tile_class, const Surroundings& around) {
    const auto asked = around.question();
    if (mixed_.code(coder, tile_class == PackedClass::mixed, classes_.output(asked.inputs, 0), asked.fine,
                    asked.coarse))
      return kMixed;
    const auto is_lit = lit_.code(
        coder,
        [tile_class](Probability lit) {
          return tile_class == PackedClass::free ? lit >= 32768 : tile_class == PackedClass::lit;
        },
        classes_.output(asked.inputs, 1), asked.fine, asked.coarse);
    return is_lit ? kLit : kDark;
  }
  // Codes how many of `length` tiles in even surroundings are as these: `kept`, as for run().
  template <class Coder>
  uint32_t quiet_tiles(Coder& coder, uint32_t kept, bool around, uint32_t length) {
    Count& broken = counts_.quiet[around][static_cast<size_t>(std::bit_width(length)) - 1];
    if (!broken.code(coder, kept < length)) return length;
    uint32_t number = 0;
    while (number + 1 < length && !coder.code(kept == number, 65536 / (length - number))) ++number;
    return number;
  }
  // Codes the class of a tile that is not as its even surroundings.
  template <class Coder>
  uint8_t odd_tile(Coder& coder, PackedClass tile_class, bool around) {
    if (counts_.odd_is_mixed[around].code(coder, tile_class == PackedClass::mixed)) return kMixed;
    return around ? kDark : kLit;
  }

  template <class Coder>
  Motion motion(Coder& coder, Motion motion, Motion predicted) {
    if (counts_.same_motion.code(coder, motion == predicted || motion == kAnyMotion)) return predicted;
    const int dx = number(coder, motion.dx - predicted.dx, 0), dy = number(coder, motion.dy - predicted.dy, 1);
    return {std::clamp(predicted.dx + dx, -kMostMotion, kMostMotion),
            std::clamp(predicted.dy + dy, -kMostMotion, kMostMotion)};
  }

 private:
  static constexpr uint32_t kSizes = 10;  // of numbers, in bits

  struct Counts {
    std::array<std::array<std::array<Count, 7>, 8>, 2> breaks;  // value of the run, its length - 1, pixels kept
    std::array<std::array<Count, 6>, 2> quiet;                  // value, bits of the length - 1
    std::array<Count, 2> odd_is_mixed;
    Count same_motion;
    std::array<std::array<Count, kSizes>, 2> sizes;
  };

  static const Counts& initial() {
    static const Counts counts = [] {
      Counts made;
      for (auto& value : made.breaks)
        for (size_t length = 1; length <= 8; ++length)
          for (size_t kept = 0; kept < 7; ++kept)
            value[length - 1][kept] = {static_cast<uint16_t>(65535 / (length - std::min(kept, length - 1))), 12};
      for (auto& value : made.quiet)
        value = {{{700, 30}, {1700, 30}, {3600, 30}, {7500, 30}, {15000, 30}, {19000, 30}}};
      made.odd_is_mixed.fill({56000, 30});
      made.same_motion = {50000, 4};
      for (auto& axis : made.sizes) axis.fill({32768, 2});
      return made;
    }();
    return counts;
  }

  // Codes |value|, at most 1,023, in P. Elias's gamma code (1975) with counts for the length, then the sign.
  template <class Coder>
  int number(Coder& coder, int value, size_t axis) {
    const auto size = static_cast<uint32_t>(std::abs(value));
    uint32_t bits = 0;
    while (bits < kSizes && counts_.sizes[axis][bits].code(coder, size >> bits != 0)) ++bits;
    if (bits == 0) return 0;
    uint32_t decoded = 1;
    for (uint32_t bit = bits - 1; bit-- > 0;) decoded = decoded << 1 | coder.code(size >> bit & 1, 32768);
    return coder.code(value < 0, 32768) ? -static_cast<int>(decoded) : static_cast<int>(decoded);
  }

  const typename Windows::Pixels& pixels_ = net<typename Windows::Pixels>();
  const typename Windows::Runs& runs_ = net<typename Windows::Runs>();
  const typename Surroundings::Classes& classes_ = net<typename Surroundings::Classes>();
  Predictor<32, 256> pixel_;
  Predictor<8, 16> run_;
  Predictor<16, 256> mixed_, lit_;
  Counts counts_;
};

}  // namespace gnomon::protocol::context
