// What the frames of several queues take of a device that runs them at the same time.
//
// A frame's timestamps span whatever ran beside it: the spans of two queues add up to more than the time that passed.
// Tenants pay for device time, and admission counts on what is left of it, so that each span is scaled by how much of
// all recent spans the device really passed; a frame that takes longer still pays more, in proportion.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <mutex>

namespace gnomon::gpu {

// Any thread.
class Overlap {
 public:
  // The device time of a span of device timestamps, nanoseconds: at most its length. Spans come in the order of their
  // ends, or nearly so.
  uint64_t device_ns(uint64_t begin_ns, uint64_t end_ns) {
    const uint64_t span_ns = end_ns - begin_ns;
    const std::lock_guard lock(mutex_);
    const uint64_t from_ns = std::max(begin_ns, passed_until_ns_);
    passed_ns_ = kKept * passed_ns_ + static_cast<double>(end_ns - std::min(end_ns, from_ns));
    spans_ns_ = kKept * spans_ns_ + static_cast<double>(span_ns);
    passed_until_ns_ = std::max(passed_until_ns_, end_ns);
    if (spans_ns_ <= 0) return span_ns;
    return static_cast<uint64_t>(
        std::llround(static_cast<double>(span_ns) * std::min(1.0, passed_ns_ / spans_ns_)));
  }

 private:
  static constexpr double kKept = 1 - 1.0 / 32;  // of the sums, from span to span

  std::mutex mutex_;
  uint64_t passed_until_ns_ = 0;
  double passed_ns_ = 0, spans_ns_ = 0;  // of recent spans: the time that passed during any of them, and their sum
};

}  // namespace gnomon::gpu
