// What the nets see of the surroundings of a pixel, of a run of pixels and of a tile.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <type_traits>

#include "protocol/context/net.h"

namespace gnomon::protocol::context {

// The class that a tile is coded as; kOutside is for tiles that are not known, as those outside the slice.
enum : uint8_t { kDark = 0, kLit = 1, kMixed = 2, kOutside = 3 };

// A net's inputs, and small contexts for what corrects it.
template <class Net>
struct Question {
  typename Net::Inputs inputs{};
  size_t fine = 0, coarse = 0;
};

// A row of a tile's pixels and what is known around it. In each window bit 8 is the tile's leftmost pixel.
template <bool Referenced>
struct RowWindows {
  using Pixels = std::conditional_t<Referenced, ReferencePixelNet, PixelNet>;
  using Runs = std::conditional_t<Referenced, ReferenceRunNet, RunNet>;

  uint32_t now = 0;  // the row itself, as far as it is known
  uint32_t above1 = 0, above2 = 0, above3 = 0;
  std::array<uint32_t, 5> reference{};     // its rows from two above to two below
  uint32_t y = 0;                          // of the row in the tile
  uint32_t right = 0;                      // class of the tile to the right
  bool all_lit = false, all_dark = false;  // the rows of this tile above; both are true of row 0

  // `Count` pixels from `From` on, relative to the pixel that the row has been shifted to: each row is shifted once, as
  // shifting it for every span took a tenth more time.
  template <int From, int Count>
  static uint32_t span(uint32_t shifted) {
    return shifted >> (8 + From) & ((1u << Count) - 1);
  }
  bool last(int at) const { return (now >> (7 + at) & 1) != 0; }

  // A pixel's surroundings are even if they all have the value of the pixel above. Bit i: those of the tile's pixel i.
  uint32_t even() const {
    const auto changes = [](uint32_t row) { return row ^ row >> 1; };  // bit i: from pixel i to the next
    uint32_t uneven = above1 ^ above2;
    if constexpr (Referenced) {
      const uint32_t near = changes(above1), far = changes(above2), up = changes(reference[1]),
                     level = changes(reference[2]), down = changes(reference[3]);
      uneven |= (above1 ^ reference[1]) | (above1 ^ reference[2]) | (above1 ^ reference[3]);
      const uint32_t beside = near | far | up | level | down;  // -1..1 of all
      uneven |= beside << 1 | beside | level << 2 | level >> 1 | near >> 1;
    } else {
      const uint32_t near = changes(above1), far = changes(above2), beside = near | far;
      uneven |= beside << 1 | beside | beside >> 1 | near << 2 | near >> 2;
    }
    return ~uneven >> 8 & 0xff;
  }
  // The number of pixels from `at` on that are in even surroundings and likely as the two before them; 0: none.
  int run(int at, uint32_t even) const {
    const uint32_t before = span<-2, 2>(now >> at), above = span<0, 1>(above1 >> at);
    return before == above * 3 ? std::countr_one(even >> at) : 0;
  }

  // Whether a run of `length` from `at` on breaks.
  [[gnu::always_inline]] Question<Runs> about_run(int at, int length) const {
    const uint32_t lit = last(at), same = 0 - lit;
    const int end = at + length - 1;
    const auto other = [&](uint32_t row) { return (row ^ same) >> end; };  // 1: not as the run
    const uint32_t uniform = (lit != 0 ? all_lit : all_dark) && (((now >> 8) ^ same) & ((1u << at) - 1)) == 0;
    const uint32_t place = static_cast<uint32_t>(length - 1) | uniform << 3;
    const uint32_t a1 = other(above1), a2 = other(above2);
    Question<Runs> question{.fine = static_cast<size_t>(length - 1), .coarse = place};
    if constexpr (Referenced) {
      const uint32_t up = other(reference[1]), level = other(reference[2]), down = other(reference[3]);
      question.inputs = {
          place | y << 4 | span<2, 3>(a1) << 7 | span<2, 3>(level) << 10 | span<1, 3>(down) << 13,
          span<1, 3>(a2) | span<1, 3>(up) << 3 | span<1, 3>(down) << 6 | span<2, 3>(level) << 9 | lit << 12};
    } else {
      question.inputs = {place | y << 4 | span<2, 4>(a1) << 7 | span<2, 4>(a2) << 11 | lit << 15,
                         span<0, 5>(other(above3)) | span<2, 4>(a2) << 5 | span<3, 2>(a1) << 9 | uniform << 11};
    }
    return question;
  }

  // Whether pixel `at` is lit.
  [[gnu::always_inline]] Question<Pixels> about_pixel(int at) const {
    const uint32_t left = now >> at, a1 = above1 >> at, a2 = above2 >> at;
    const uint32_t nearest = span<-2, 2>(left) | span<-1, 3>(a1) << 2;
    const uint32_t uniform = all_lit || all_dark;
    Question<Pixels> question{.fine = nearest};
    question.inputs[0] = span<-4, 4>(left) | span<-3, 8>(a1) << 4 | span<-1, 4>(a2) << 12;
    if constexpr (Referenced) {
      const uint32_t up = reference[1] >> at, level = reference[2] >> at, down = reference[3] >> at;
      question.coarse = nearest | span<-1, 3>(level) << 5;
      question.inputs[1] =
          span<-1, 1>(left) | span<-1, 3>(up) << 1 | span<-3, 7>(level) << 4 | span<-2, 5>(down) << 11;
      question.inputs[2] =
          span<-2, 2>(left) | span<-2, 5>(a1) << 2 | span<-2, 5>(up) << 7 | span<-1, 4>(level) << 12;
      question.inputs[3] = span<-1, 1>(left) | span<0, 1>(a1) << 1 | span<-1, 3>(reference[0] >> at) << 2 |
                           span<-1, 3>(reference[4] >> at) << 5 | span<2, 3>(level) << 8 | span<2, 3>(a1) << 11 |
                           span<0, 1>(a2) << 14 | uniform << 15;
    } else {
      question.coarse = nearest | span<-3, 1>(left) << 5 | span<2, 1>(a1) << 6 | span<0, 1>(a2) << 7;
      question.inputs[1] =
          span<-1, 1>(left) | span<0, 2>(a1) << 1 | span<-4, 9>(a2) << 3 | span<-1, 4>(above3 >> at) << 12;
      question.inputs[2] = static_cast<uint32_t>(at) | y << 3 | right << 6 | span<-1, 1>(left) << 8 |
                           span<0, 2>(a1) << 9 | span<5, 4>(a1) << 11 | uniform << 15;
    }
    return question;
  }
};

// What is known around a tile.
template <bool Referenced>
struct TileSurroundings {
  using Classes = std::conditional_t<Referenced, ReferenceClassNet, ClassNet>;

  uint32_t west = 0, north = 0, north_east = 0, north_west = 0;      // classes
  uint32_t west2 = 0, north2 = 0, north_east2 = 0, north_west2 = 0;  // one tile further
  // The last pixel row above: of the tile to the left, of this one, of the one to the right.
  std::array<uint8_t, 3> above{};
  uint8_t above2 = 0;  // the row above that, of this tile
  // Pixel rows from two above the tile to two below, each of twelve pixels from two to its left on.
  std::array<uint32_t, 12> reference{};

  Question<Classes> question() const {
    const uint32_t near = west | north << 2 | north_east << 4 | north_west << 6;
    const uint32_t far = west2 | north2 << 2 | north_east2 << 4 | north_west2 << 6;
    const uint32_t edge = uint32_t{above[1] != 0} | uint32_t{above[1] == 0xff} << 1;
    Question<Classes> question{.fine = west | north << 2, .coarse = near};
    if constexpr (Referenced) {
      Rows all = rows(0, 12), upper = rows(2, 6), lower = rows(6, 10);
      const uint32_t any = inner(upper.any | lower.any), every = inner(upper.all & lower.all);
      const uint32_t flags = uint32_t{any != 0} | uint32_t{every == 0xff} << 1 | uint32_t{all.any != 0} << 2 |
                             uint32_t{all.all == 0xfff} << 3 | uint32_t{inner(upper.any) != 0} << 4 |
                             uint32_t{inner(upper.all) == 0xff} << 5 | uint32_t{inner(lower.any) != 0} << 6 |
                             uint32_t{inner(lower.all) == 0xff} << 7;
      uint32_t left = 0, right = 0;
      for (size_t y = 0; y < 8; ++y) {
        left |= (reference[y + 2] & 1) << y;
        right |= (reference[y + 2] >> 11) << y;
      }
      const uint32_t first = inner(reference[0]), last = inner(reference[11]);
      const uint32_t beyond = uint32_t{first != 0} | uint32_t{first == 0xff} << 1 | uint32_t{last != 0} << 2 |
                              uint32_t{last == 0xff} << 3;
      question.coarse = (flags & 15) | west << 4 | north << 6;
      question.inputs = {near | flags << 8, inner(reference[2]) | inner(reference[9]) << 8, left | right << 8,
                         above[1] | west << 8 | north << 10, far | beyond << 8 | edge << 12};
    } else {
      question.inputs = {near | uint32_t{above[1]} << 8,
                         far | uint32_t{above[0]} >> 4 << 8 | (above[2] & 15u) << 12,
                         above2 | west << 8 | north << 10 | edge << 12};
    }
    return question;
  }

 private:
  struct Rows {
    uint32_t any = 0, all = 0xfff;
  };
  Rows rows(size_t first, size_t end) const {
    Rows made;
    for (size_t y = first; y < end; ++y) {
      made.any |= reference[y];
      made.all &= reference[y];
    }
    return made;
  }
  static uint32_t inner(uint32_t row) { return row >> 2 & 0xff; }
};

}  // namespace gnomon::protocol::context
