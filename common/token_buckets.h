// A token bucket for each key, such as a client's network: `at_once` tokens, refilled at `per_second`. Whoever asks a
// server for more than that is turned away before it costs anything.
//
// Pure: no clock. One thread at a time.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <map>
#include <vector>

#include "common/clock.h"

namespace gnomon {

class TokenBucket {
 public:
  TokenBucket(double at_once, double per_second) : at_once_(at_once), per_second_(per_second), left_(at_once) {}

  double left(TimePoint now) const {
    return std::min(at_once_, left_ + per_second_ * std::max(0.0, to_seconds(now - counted_)));
  }
  // Returns false, and takes nothing, if less than `tokens` are left. What is more than all takes all.
  bool take(double tokens, TimePoint now) {
    tokens = std::min(tokens, at_once_);
    left_ = left(now);
    counted_ = std::max(counted_, now);
    if (left_ < tokens) return false;
    left_ -= tokens;
    return true;
  }

 private:
  double at_once_, per_second_, left_;
  TimePoint counted_{};
};

template <class Key>
class TokenBuckets {
 public:
  TokenBuckets(double at_once, double per_second) : full_(at_once, per_second) {}

  bool take(const Key& key, double tokens, TimePoint now) {
    if (buckets_.size() >= kMaxKeys && !buckets_.contains(key)) make_room(now);
    return buckets_.try_emplace(key, full_).first->second.take(tokens, now);
  }

  // Most keys that are remembered. Beyond it, those are forgotten that have most of their tokens left, a share of all at
  // a time: a flood of fresh addresses forgets its own, and none that has spent what it may.
  static constexpr size_t kMaxKeys = 16'384;
  size_t size() const { return buckets_.size(); }

 private:
  // So many are forgotten together that a flood of fresh keys pays for sorting once in a thousand.
  static constexpr size_t kForgottenTogether = kMaxKeys / 8;

  // To forget a key is to fill its bucket.
  void make_room(TimePoint now) {
    std::vector<double> most_first;
    for (const auto& [key, bucket] : buckets_) most_first.push_back(bucket.left(now));
    const auto last = most_first.begin() + kForgottenTogether - 1;
    std::nth_element(most_first.begin(), last, most_first.end(), std::greater<>());
    size_t forgotten = 0;
    std::erase_if(buckets_, [&, least = *last](const auto& entry) {
      return forgotten < kForgottenTogether && entry.second.left(now) >= least && ++forgotten > 0;
    });
  }

  const TokenBucket full_;
  std::map<Key, TokenBucket> buckets_;
};

}  // namespace gnomon
