// Corrects a net's prediction with the statistics of the slice so far: for every range of predictions and small
// context, what the bits were, as by the adaptive probability maps of M. Mahoney's PAQ. The mean of two such maps is
// taken. Counts adapt fast at first and slower the more bits they have seen (as lpaq's; compare the two rates of VVC,
// H.266).
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "protocol/context/logistic.h"

namespace gnomon::protocol::context {

// Coders do not code 0 and 1.
inline Probability codable(uint32_t p) { return p < 32 ? 32u : p > 65535 - 32 ? 65535u - 32u : p; }

struct Count {
  uint16_t one = 32768;  // in 1/65536
  uint16_t seen = 0;

  void learn(bool bit) {
    static constexpr int kMostSeen = 60;
    static constexpr std::array<int, kMostSeen + 1> kRates = [] {
      std::array<int, kMostSeen + 1> rates{};
      for (int n = 0; n <= kMostSeen; ++n) rates[static_cast<size_t>(n)] = 655360 / (10 * n + 16) >> 1;
      return rates;
    }();
    const int step = (((0 - int{bit}) & 65535) - int{one}) * kRates[seen] >> 15;
    one = static_cast<uint16_t>(one + step);
    seen = static_cast<uint16_t>(seen + uint16_t{seen < kMostSeen});
  }

  template <class Coder>
  bool code(Coder& coder, bool bit) {
    bit = coder.code(bit, codable(one));
    learn(bit);
    return bit;
  }
};

template <size_t Fine, size_t Coarse>
class Predictor {
 public:
  Predictor() { reset(); }
  void reset() {
    static const Predictor initial{Initial{}};
    *this = initial;
  }

  template <class Coder>
  [[gnu::always_inline]] bool code(Coder& coder, bool bit, int stretched, size_t fine, size_t coarse) {
    return code(
        coder, [bit](Probability) { return bit; }, stretched, fine, coarse);
  }
  // Codes the bit that choose(probability of 1) returns.
  template <class Coder, class Choose>
  requires std::is_invocable_v<Choose, Probability>
  [[gnu::always_inline]] bool code(Coder& coder, Choose choose, int stretched, size_t fine, size_t coarse) {
    const int from_least = std::clamp(stretched, -kMaxStretched, kMaxStretched) + kMaxStretched + 1;
    const size_t range = static_cast<size_t>(from_least) >> kRangeBits;
    Count& first = fine_[range * Fine + fine];
    Count& second = coarse_[range / 2 * Coarse + coarse];
    const Probability one = codable((uint32_t{first.one} + second.one) / 2);
    const bool bit = coder.code(choose(one), one);
    first.learn(bit);
    second.learn(bit);
    return bit;
  }

 private:
  struct Initial {};
  static constexpr int kRangeBits = 7;
  static constexpr size_t kRanges = 4096 >> kRangeBits;
  static constexpr uint16_t kSeenAtFirst = 20;

  explicit Predictor(Initial) {
    const auto middle = [](size_t range, int bits) {
      return squash((static_cast<int>(range) << bits) + (1 << bits) / 2 - kMaxStretched - 1);
    };
    for (size_t i = 0; i < fine_.size(); ++i)
      fine_[i] = {static_cast<uint16_t>(middle(i / Fine, kRangeBits)), kSeenAtFirst};
    for (size_t i = 0; i < coarse_.size(); ++i)
      coarse_[i] = {static_cast<uint16_t>(middle(i / Coarse, kRangeBits + 1)), kSeenAtFirst};
  }

  std::array<Count, kRanges * Fine> fine_;
  std::array<Count, kRanges / 2 * Coarse> coarse_;
};

}  // namespace gnomon::protocol::context
