// Small neural networks that predict the next bit from what is already known around a pixel or a tile. They contribute
// statistics that slices of 1.1 kB are too short to learn.
//
// A net is a sum of parts. Each part has at most 16 binary inputs and one hidden layer of rectified units, so that what
// it says for every input fits a table: predicting a bit is one look-up and one addition per part. No floating point is
// involved: every machine gets the same result. tests/bench/train_nets.cpp trains the weights, which net_weights.inc
// holds.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace gnomon::protocol::context {

inline constexpr int kWeightBits = 6;   // fractional bits of the first layer's weights
inline constexpr int kOutputBits = 8;   // of the second layer's
inline constexpr int kMostSaid = 8191;  // by one part
inline constexpr size_t kHidden = 32;   // units of a part

// `Bits`: the number of inputs of each part.
template <size_t Outputs, size_t... Bits>
class Net {
 public:
  static constexpr size_t kOutputs = Outputs;
  static constexpr size_t kParts = sizeof...(Bits);
  static constexpr std::array<size_t, kParts> kBits{Bits...};
  // The inputs of each part, the first in the lowest bit.
  using Inputs = std::array<uint32_t, kParts>;

  // `weights` has for each part the weights of each input (one for each unit), the units' biases, and for each output
  // a weight for each unit and a bias.
  explicit Net(std::span<const int16_t> weights) {
    for (size_t part = 0; part < kParts; ++part) {
      tables_[part].resize(Outputs << kBits[part]);
      tabulate(weights.first(weights_of_part(part)), kBits[part], tables_[part]);
      weights = weights.subspan(weights_of_part(part));
    }
  }

  static constexpr size_t weights_of_part(size_t part) {
    return (kBits[part] + 1) * kHidden + Outputs * (kHidden + 1);
  }

  // The stretched probability (logistic.h) that the output gives, not yet clamped.
  int output(const Inputs& inputs, size_t output = 0) const {
    int sum = 0;
    for (size_t part = 0; part < kParts; ++part) sum += tables_[part][inputs[part] * Outputs + output];
    return sum;
  }

 private:
  using Units = std::array<int16_t, kHidden>;
  // What the inputs in a byte add to the units, for all its values.
  static std::array<Units, 256> sums(std::span<const int16_t> rows) {
    std::array<Units, 256> all{};
    for (size_t value = 1; value < 256; ++value) {
      const auto lowest = static_cast<size_t>(__builtin_ctzll(value));
      if ((lowest + 1) * kHidden > rows.size()) continue;
      for (size_t unit = 0; unit < kHidden; ++unit)
        all[value][unit] = static_cast<int16_t>(all[value & (value - 1)][unit] + rows[lowest * kHidden + unit]);
    }
    return all;
  }

  static void tabulate(std::span<const int16_t> weights, size_t bits, std::vector<int16_t>& table) {
    const size_t low_bits = std::min<size_t>(bits, 8);
    const auto low = sums(weights.first(low_bits * kHidden));
    const auto high = sums(weights.subspan(low_bits * kHidden, (bits - low_bits) * kHidden));
    const int16_t* biases = &weights[bits * kHidden];
    for (size_t value = 0; value < size_t{1} << bits; ++value) {
      Units units;
      for (size_t unit = 0; unit < kHidden; ++unit) {
        const auto sum = static_cast<int16_t>(biases[unit] + low[value & 0xff][unit] + high[value >> 8][unit]);
        units[unit] = std::max(sum, int16_t{0});
      }
      for (size_t output = 0; output < Outputs; ++output) {
        const int16_t* of_output = &weights[(bits + 1) * kHidden + output * (kHidden + 1)];
        int said = 0;
        for (size_t unit = 0; unit < kHidden; ++unit) said += int{units[unit]} * int{of_output[unit]};
        said = std::clamp((said >> kWeightBits) + of_output[kHidden], -kMostSaid, kMostSaid);
        table[value * Outputs + output] = static_cast<int16_t>(said);
      }
    }
  }

  std::array<std::vector<int16_t>, kParts> tables_;
};

// contexts.h has the inputs. Outputs of a tile: mixed; if it is not mixed, lit.
using PixelNet = Net<1, 16, 16, 16>;
using ReferencePixelNet = Net<1, 16, 16, 16, 16>;
using RunNet = Net<1, 16, 12>;
using ReferenceRunNet = Net<1, 16, 13>;
using ClassNet = Net<2, 16, 16, 14>;
using ReferenceClassNet = Net<2, 16, 16, 16, 12, 14>;

// Created at the first call, 3 MB in all. Any thread.
template <class Which>
const Which& net();
template <>
const PixelNet& net();
template <>
const ReferencePixelNet& net();
template <>
const RunNet& net();
template <>
const ReferenceRunNet& net();
template <>
const ClassNet& net();
template <>
const ReferenceClassNet& net();

}  // namespace gnomon::protocol::context
