// The generators' random numbers: PCG32 (O'Neill, "PCG: A Family of Simple Fast Space-Efficient Statistically Good
// Algorithms for Random Number Generation", 2014). A seed gives the same sequence on every machine.
#pragma once

#include <cstdint>

namespace gnomon::scenes::assets {

class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed * 0x9e3779b97f4a7c15u + 0x853c49e6748fea9bu) { next(); }

  uint32_t next() {
    const uint64_t old = state_;
    state_ = old * 6364136223846793005u + 1442695040888963407u;
    const auto shifted = static_cast<uint32_t>(((old >> 18) ^ old) >> 27);
    const auto turn = static_cast<uint32_t>(old >> 59);
    return (shifted >> turn) | (shifted << ((32 - turn) & 31));
  }

  // Uniform in [0, 1), [low, high) and {0, ..., count - 1}.
  float unit() { return static_cast<float>(next() >> 8) * 0x1p-24f; }
  float range(float low, float high) { return low + (high - low) * unit(); }
  uint32_t below(uint32_t count) { return static_cast<uint32_t>((uint64_t{next()} * count) >> 32); }

 private:
  uint64_t state_;
};

}  // namespace gnomon::scenes::assets
