// The probability of each decision of a slice: nets, blends that correct them within the slice, and plain counts where
// a net would be wasted. Encoder and decoder run the same code. One slice at a time.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <type_traits>

#include "common/packed_mask.h"
#include "protocol/context/blend.h"
#include "protocol/context/net.h"

namespace gnomon::protocol::context {

// The class that a tile is coded as; kOutside is for tiles that are not known, as those outside the slice.
enum : uint8_t { kDark = 0, kLit = 1, kMixed = 2, kOutside = 3 };

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

template <bool Referenced>
class SliceModel {
 public:
  static constexpr bool kReferenced = Referenced;
  using Pixels = std::conditional_t<Referenced, ReferencePixelNet, PixelNet>;
  using Classes = std::conditional_t<Referenced, ReferenceClassNet, ClassNet>;

  SliceModel() { reset(); }

  void reset() {
    pixel_blend_.reset();
    mixed_blend_.reset();
    lit_blend_.reset();
    runs_ = initial_runs();
    quiet_ = initial_quiet();
    same_motion_ = Count{50000, 4};
    sizes_.fill(Count{32768, 2});
  }

  // Codes a pixel whose neighbourhood is not uniform.
  template <class Coder>
  bool pixel(Coder& coder, bool bit, const typename Pixels::Inputs& inputs, size_t near, size_t other, size_t set) {
    typename Pixels::Units units;
    pixels_.hide(inputs, units);
    bit = coder.code(bit, pixel_blend_.predict(pixels_.output(units, 0), near, other, set));
    pixel_blend_.learn(bit);
    return bit;
  }
  // Codes a pixel whose neighbourhood is all dark or all lit.
  template <class Coder>
  bool run_pixel(Coder& coder, bool bit, bool around, uint8_t place) {
    return counted(coder, bit, runs_[around][place]);
  }

  // Codes a tile's class and returns it: kDark, kLit or kMixed. A free tile takes the likelier of dark and lit.
  template <class Coder>
  uint8_t tile(Coder& coder, PackedClass tile_class, const typename Classes::Inputs& inputs, size_t near,
               size_t other, size_t set) {
    typename Classes::Units units;
    classes_.hide(inputs, units);
    const Probability mixed = mixed_blend_.predict(classes_.output(units, 0), near, other, set);
    const bool is_mixed = coder.code(tile_class == PackedClass::mixed, mixed);
    mixed_blend_.learn(is_mixed);
    if (is_mixed) return kMixed;
    const Probability lit = lit_blend_.predict(classes_.output(units, 1), near, other, set);
    const bool is_lit = coder.code(lit_or_free(tile_class, lit), lit);
    lit_blend_.learn(is_lit);
    return is_lit ? kLit : kDark;
  }
  // Codes the class of a tile whose neighbourhood is all dark or all lit.
  template <class Coder>
  uint8_t quiet_tile(Coder& coder, PackedClass tile_class, bool around) {
    if (counted(coder, tile_class == PackedClass::mixed, quiet_[around][0])) return kMixed;
    Count& lit = quiet_[around][1];
    return counted(coder, lit_or_free(tile_class, lit.probability()), lit) ? kLit : kDark;
  }

  template <class Coder>
  Motion motion(Coder& coder, Motion motion, Motion predicted) {
    if (counted(coder, motion == predicted || motion == kAnyMotion, same_motion_)) return predicted;
    const int dx = number(coder, motion.dx - predicted.dx, 0), dy = number(coder, motion.dy - predicted.dy, 1);
    return {std::clamp(predicted.dx + dx, -kMostMotion, kMostMotion),
            std::clamp(predicted.dy + dy, -kMostMotion, kMostMotion)};
  }

 private:
  using Runs = std::array<std::array<Count, 256>, 2>;
  using Quiet = std::array<std::array<Count, 2>, 2>;

  static bool lit_or_free(PackedClass tile_class, Probability lit) {
    return tile_class == PackedClass::free ? lit >= 32768 : tile_class == PackedClass::lit;
  }

  template <class Coder>
  static bool counted(Coder& coder, bool bit, Count& count) {
    bit = coder.code(bit, count.probability());
    count.learn(bit);
    return bit;
  }

  // Codes |value|, at most 1,023, in P. Elias's gamma code (1975) with counts for the length, then the sign.
  template <class Coder>
  int number(Coder& coder, int value, size_t axis) {
    constexpr uint32_t kMostBits = 10;
    const auto size = static_cast<uint32_t>(std::abs(value));
    uint32_t bits = 0;
    while (bits < kMostBits && counted(coder, size >> bits != 0, sizes_[axis * (kMostBits + 1) + bits])) ++bits;
    if (bits == 0) return 0;
    uint32_t decoded = 1;
    for (uint32_t bit = bits - 1; bit-- > 0;) decoded = decoded << 1 | coder.code(size >> bit & 1, 32768);
    return coder.code(value < 0, 32768) ? -static_cast<int>(decoded) : static_cast<int>(decoded);
  }

  // The counts that code pixels in uniform neighbourhoods begin with what the net would predict there.
  static const Runs& initial_runs() {
    static const Runs runs = [] {
      Runs made;
      typename Pixels::Inputs inputs;
      typename Pixels::Units units;
      for (int around = 0; around < 2; ++around) {
        inputs.fill(around != 0 ? 0xff : 0);
        for (unsigned place = 0; place < 256; ++place) {
          inputs[0] = static_cast<uint8_t>(place);
          net<Pixels>().hide(inputs, units);
          made[around][place] = Count{static_cast<uint16_t>(squash(net<Pixels>().output(units, 0))), 24};
        }
      }
      return made;
    }();
    return runs;
  }
  static Quiet initial_quiet() { return {{{Count{600, 30}, Count{100, 30}}, {Count{600, 30}, Count{65436, 30}}}}; }

  template <class Which>
  static const Which& net() {
    if constexpr (std::is_same_v<Which, PixelNet>) return pixel_net();
    if constexpr (std::is_same_v<Which, ReferencePixelNet>) return reference_pixel_net();
    if constexpr (std::is_same_v<Which, ClassNet>) return class_net();
    if constexpr (std::is_same_v<Which, ReferenceClassNet>) return reference_class_net();
  }

  const Pixels& pixels_ = net<Pixels>();
  const Classes& classes_ = net<Classes>();
  Blend<1 << 14, 1 << 14, 32> pixel_blend_;
  Blend<1 << 10, 1 << 12, 16> mixed_blend_, lit_blend_;
  Runs runs_;
  Quiet quiet_;
  Count same_motion_;
  std::array<Count, 22> sizes_;
};

}  // namespace gnomon::protocol::context
