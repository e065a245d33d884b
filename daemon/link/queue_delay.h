// How long datagrams wait in queues on the path: their one-way delay beyond the least delay of the last minute.
//
// After LEDBAT (RFC 6817): the base is the minimum of the last minute, so that the clocks' offset and drift cancel out;
// a sample is the minimum of four datagrams, which filters jitter.
#pragma once

#include <algorithm>
#include <array>

#include "common/clock.h"

namespace gnomon::daemon {

class QueueDelay {
 public:
  // `one_way` may have any constant offset, including a negative one.
  void add(Nanoseconds one_way, TimePoint now) {
    if (!begun_ || now - bucket_began_ >= kBucket) next_bucket(now);
    buckets_[bucket_] = std::min(buckets_[bucket_], one_way);
    recent_[next_++ % recent_.size()] = one_way;
  }

  bool known() const { return next_ >= recent_.size(); }

  Nanoseconds current() const {  // 0 until known()
    if (!known()) return {};
    return *std::min_element(recent_.begin(), recent_.end()) - base();
  }

  Nanoseconds base() const { return *std::min_element(buckets_.begin(), buckets_.end()); }

 private:
  static constexpr Nanoseconds kBucket = std::chrono::seconds(10);

  void next_bucket(TimePoint now) {
    if (!begun_) buckets_.fill(Nanoseconds::max());
    begun_ = true;
    bucket_began_ = now;
    bucket_ = (bucket_ + 1) % buckets_.size();
    buckets_[bucket_] = Nanoseconds::max();
  }

  bool begun_ = false;
  TimePoint bucket_began_{};
  size_t bucket_ = 0;
  std::array<Nanoseconds, 6> buckets_{};
  std::array<Nanoseconds, 4> recent_{};
  size_t next_ = 0;
};

}  // namespace gnomon::daemon
