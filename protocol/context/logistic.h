// Converts probabilities to stretched numbers, ln(p / (1 - p)) in units of 1/256, and back, with tables of integers
// that are the same on every machine. After M. Mahoney, "Adaptive Weighing of Context Models for Lossless Data
// Compression" (2005).
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "protocol/context/binary_coder.h"

namespace gnomon::protocol::context {

inline constexpr int kMaxStretched = 2047;

// Index: kMaxStretched + the stretched number. Value: p in units of 1/65536.
extern const std::array<uint16_t, 4096> kSquashed;
// Index: p in units of 1/4096. Value: the stretched number.
extern const std::array<int16_t, 4096> kStretched;

inline Probability squash(int stretched) {
  return kSquashed[static_cast<size_t>(std::clamp(stretched, -kMaxStretched, kMaxStretched) + kMaxStretched)];
}
inline int stretch(Probability p) { return kStretched[p >> 4]; }

}  // namespace gnomon::protocol::context
