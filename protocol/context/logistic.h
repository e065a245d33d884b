// Converts stretched numbers, ln(p / (1 - p)) in units of 1/256, to probabilities, with a table of integers that is the
// same on every machine. After M. Mahoney, "Adaptive Weighing of Context Models for Lossless Data
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

inline Probability squash(int stretched) {
  return kSquashed[static_cast<size_t>(std::clamp(stretched, -kMaxStretched, kMaxStretched) + kMaxStretched)];
}

}  // namespace gnomon::protocol::context
