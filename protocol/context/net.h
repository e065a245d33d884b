// Small neural networks that predict the next bit from what is already known around a pixel or a tile. They contribute
// statistics that slices of 1.1 kB are too short to learn.
//
// Each has one hidden layer of rectified units over binary inputs. Inputs come in groups of eight bits, so that the
// first layer is one table look-up per group and a few additions of 16-bit integers. No floating point is involved:
// every machine gets the same result. tests/bench/train_nets.cpp trains the weights, which net_weights.inc holds.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>

namespace gnomon::protocol::context {

// The meaning of a group's eight bits: fields from the lowest bit on. A field of one bit has one row of weights (a
// weight for each hidden unit), which counts if the bit is set; a wider field has a row for each of its values.
struct GroupShape {
  std::array<uint8_t, 8> widths{};  // 0: no further field

  // Calls visit(row) for each row of weights that `value` selects. The group's rows begin at `first_row`; returns their
  // end.
  template <class Visit>
  size_t for_rows(uint32_t value, size_t first_row, Visit visit) const {
    for (const uint8_t width : widths) {
      if (width == 0) break;
      const uint32_t field = value & ((1u << width) - 1);
      value >>= width;
      if (width > 1) visit(first_row + field);
      if (width == 1 && field != 0) visit(first_row);
      first_row += width > 1 ? size_t{1} << width : 1;
    }
    return first_row;
  }
};

inline constexpr GroupShape kPixels{{1, 1, 1, 1, 1, 1, 1, 1}};
inline constexpr GroupShape kPlace{{3, 3, 2}};       // x and y within the tile, class of the tile to the right
inline constexpr GroupShape kClasses{{2, 2, 2, 2}};  // of four tiles

inline constexpr int kWeightBits = 6;  // fractional bits of the first layer's weights
inline constexpr int kOutputBits = 8;  // of the second layer's

template <size_t Groups, size_t Hidden, size_t Outputs>
class Net {
 public:
  static constexpr size_t kGroups = Groups;
  static constexpr size_t kHidden = Hidden;
  static constexpr size_t kOutputs = Outputs;
  using Inputs = std::array<uint8_t, Groups>;
  using Units = std::array<int16_t, Hidden>;

  // `weights` has the rows of all groups, the hidden biases, then for each output a weight for each unit and a bias.
  Net(const std::array<GroupShape, Groups>& shapes, std::span<const int16_t> weights) {
    size_t row = 0;
    for (size_t group = 0; group < Groups; ++group) {
      size_t end = row;
      for (uint32_t value = 0; value < 256; ++value) {
        Units& sum = tables_[group][value];
        sum.fill(0);
        end = shapes[group].for_rows(value, row, [&](size_t r) {
          for (size_t unit = 0; unit < Hidden; ++unit)
            sum[unit] = static_cast<int16_t>(sum[unit] + weights[r * Hidden + unit]);
        });
      }
      row = end;
    }
    const int16_t* next = weights.data() + row * Hidden;
    for (Units& table : tables_[0])
      for (size_t unit = 0; unit < Hidden; ++unit) table[unit] = static_cast<int16_t>(table[unit] + next[unit]);
    next += Hidden;
    for (size_t output = 0; output < Outputs; ++output) {
      for (size_t unit = 0; unit < Hidden; ++unit) outputs_[output][unit] = *next++;
      biases_[output] = *next++;
    }
  }

  void hide(const Inputs& inputs, Units& units) const {
    Lanes sum, next;
    std::memcpy(&sum, &tables_[0][inputs[0]], sizeof sum);
    for (size_t group = 1; group < Groups; ++group) {
      std::memcpy(&next, &tables_[group][inputs[group]], sizeof next);
      sum += next;
    }
    sum = sum > 0 ? sum : Lanes{};
    std::memcpy(&units, &sum, sizeof sum);
  }

  // The stretched probability (logistic.h) that the output gives.
  int output(const Units& units, size_t output) const {
    int sum = 0;
    for (size_t unit = 0; unit < Hidden; ++unit) sum += int{units[unit]} * int{outputs_[output][unit]};
    return (sum >> kWeightBits) + biases_[output];
  }

 private:
  // The vector extension of GCC and Clang, which divide it into the machine's vectors. They did not vectorise loops
  // over plain arrays; arrays of smaller vectors went through memory and took twice as long.
  using Lanes [[gnu::vector_size(Hidden * sizeof(int16_t))]] = int16_t;

  alignas(64) std::array<std::array<Units, 256>, Groups> tables_;
  std::array<Units, Outputs> outputs_;
  std::array<int, Outputs> biases_;
};

// Inputs of a pixel: its place; the eight pixels to its left; pixels of the rows above.
using PixelNet = Net<8, 32, 1>;
// The same with a reference: place; pixels to the left and above; five rows of the reference around it.
using ReferencePixelNet = Net<10, 32, 1>;
// Inputs of a tile: the classes around it; pixels above. Outputs: mixed; if it is not mixed, lit.
using ClassNet = Net<6, 16, 2>;
// The same with a reference: also what the reference has there.
using ReferenceClassNet = Net<13, 16, 2>;

inline constexpr std::array<GroupShape, 8> kPixelShapes{kPlace,  kPixels, kPixels, kPixels,
                                                        kPixels, kPixels, kPixels, kPixels};
inline constexpr std::array<GroupShape, 10> kReferencePixelShapes{kPlace,  kPixels, kPixels, kPixels, kPixels,
                                                                  kPixels, kPixels, kPixels, kPixels, kPixels};
inline constexpr std::array<GroupShape, 6> kClassShapes{kClasses, kClasses, kPixels, kPixels, kPixels, kPixels};
inline constexpr std::array<GroupShape, 13> kReferenceClassShapes{kClasses, kClasses, kPixels, kPixels, kPixels,
                                                                  kPixels,  kPixels,  kPixels, kPixels, kPixels,
                                                                  kPixels,  kPixels,  kPixels};

// Created at the first call, 450 kB in all. Any thread.
const PixelNet& pixel_net();
const ReferencePixelNet& reference_pixel_net();
const ClassNet& class_net();
const ReferenceClassNet& reference_class_net();

// The number of rows of weights of a net, for its trainer.
template <size_t Groups>
constexpr size_t rows_of(const std::array<GroupShape, Groups>& shapes) {
  size_t row = 0;
  for (const GroupShape& shape : shapes) row = shape.for_rows(0, row, [](size_t) {});
  return row;
}

}  // namespace gnomon::protocol::context
