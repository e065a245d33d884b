#include "protocol/context/logistic.h"

namespace gnomon::protocol::context {
namespace {

// Computes e^(-n/256) in units of 2^-40 by repeated multiplication of integers: rounding does not depend on the
// machine.
constexpr std::array<uint16_t, 4096> make_squashed() {
  constexpr uint64_t kOne = uint64_t{1} << 40;
  constexpr uint64_t kStep = 1095225038176;  // e^(-1/256) * 2^40, rounded
  std::array<uint16_t, 4096> table{};
  uint64_t power = kOne;  // e^(-n/256)
  for (int n = 0; n <= kMaxStretched; ++n) {
    const auto p = static_cast<uint32_t>((kOne << 16) / (kOne + power));
    table[static_cast<size_t>(kMaxStretched + n)] = static_cast<uint16_t>(std::min(p, 65535u));
    table[static_cast<size_t>(kMaxStretched - n)] = static_cast<uint16_t>(std::max(65536u - p, 1u));
    power = static_cast<uint64_t>((power >> 20) * (kStep >> 20) + (((power & 0xfffff) * (kStep >> 20)) >> 20) +
                                  (((power >> 20) * (kStep & 0xfffff)) >> 20));
  }
  table[4095] = table[4094];
  return table;
}

}  // namespace

constexpr std::array<uint16_t, 4096> kSquashed = make_squashed();

}  // namespace gnomon::protocol::context
