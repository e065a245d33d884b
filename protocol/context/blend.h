// Corrects a net's prediction with the statistics of the slice so far: adaptive counts of two contexts are mixed with
// the net's output in the logistic domain, with weights that are learned, as by the mixers of M. Mahoney's PAQ. Counts
// adapt fast at first and slower the more bits they have seen (as lpaq's; compare the two rates of VVC, H.266).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "protocol/context/logistic.h"

namespace gnomon::protocol::context {

struct Count {
  uint16_t one = 32768;  // in 1/65536
  uint16_t seen = 0;

  void learn(bool bit) {
    static constexpr int kMostSeen = 60;
    static constexpr std::array<int, kMostSeen + 1> kRates = [] {
      std::array<int, kMostSeen + 1> rates{};
      for (int n = 0; n <= kMostSeen; ++n) rates[static_cast<size_t>(n)] = 655360 / (10 * n + 16);
      return rates;
    }();
    const int step = ((bit ? 65535 - one : -int{one}) * (kRates[seen] >> 1)) >> 15;
    one = static_cast<uint16_t>(one + step);
    seen = static_cast<uint16_t>(seen + (seen < kMostSeen ? 1 : 0));
  }
  // Kept away from 0 and 1, which a coder cannot code.
  Probability probability() const { return one < 32 ? 32u : one > 65535 - 32 ? 65535u - 32u : one; }
  // The stretched probability, reduced while few bits have been seen.
  int say() const { return stretch(one) * (seen < 8 ? seen : 8) >> 3; }
};

template <size_t Contexts1, size_t Contexts2, size_t Sets>
class Blend {
 public:
  Blend() : first_(Contexts1), second_(Contexts2) { reset(); }

  void reset() {
    std::fill(first_.begin(), first_.end(), Count{});
    std::fill(second_.begin(), second_.end(), Count{});
    weights_.fill({65536, 9830, 9830});
  }

  Probability predict(int net, size_t context1, size_t context2, size_t set) {
    count1_ = &first_[context1];
    count2_ = &second_[context2];
    used_ = &weights_[set];
    says_ = {std::clamp(net, -kMaxStretched, kMaxStretched), count1_->say(), count2_->say()};
    int sum = 0;
    for (size_t i = 0; i < says_.size(); ++i) sum += (*used_)[i] * says_[i];
    predicted_ = squash(sum >> 16);
    return predicted_;
  }
  // Learns the bit that the last prediction was of.
  void learn(bool bit) {
    const int error = (bit ? 65535 : 0) - static_cast<int>(predicted_);
    for (size_t i = 0; i < says_.size(); ++i)
      (*used_)[i] = std::clamp((*used_)[i] + (error * says_[i] >> 15), -kMostWeight, kMostWeight);
    count1_->learn(bit);
    count2_->learn(bit);
  }

 private:
  static constexpr int kMostWeight = 1 << 18;  // three of them times kMaxStretched fit an int
  using Weights = std::array<int, 3>;

  std::vector<Count> first_, second_;
  std::array<Weights, Sets> weights_;
  Count* count1_ = nullptr;
  Count* count2_ = nullptr;
  Weights* used_ = nullptr;
  std::array<int, 3> says_{};
  Probability predicted_ = 0;
};

}  // namespace gnomon::protocol::context
