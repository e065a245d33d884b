#include "client/net/arrival_report.h"

#include <algorithm>

namespace gnomon::client {
namespace {

// The sequence numbers kept. Older ones no longer matter; duplicates do not get here, as the seal rejects them.
constexpr uint64_t kMost = 2 * protocol::kMaxReported;

uint16_t age_of(TimePoint arrived, TimePoint now) {
  const auto units = std::max<int64_t>(0, to_microseconds(now - arrived)) / protocol::kAgeUnitUs;
  return static_cast<uint16_t>(std::min<int64_t>(1 + units, protocol::kOldest));
}

}  // namespace

void ArrivalReport::received(uint64_t sequence, TimePoint at) {
  if (sequence < first_) return;
  if (sequence - first_ >= kMost + arrivals_.size()) {  // a long gap, whose losses are not reported
    arrivals_.clear();
    first_ = sequence;
  }
  while (arrivals_.size() <= sequence - first_) arrivals_.emplace_back();
  arrivals_[static_cast<size_t>(sequence - first_)] = at;
  while (arrivals_.size() > kMost) {
    arrivals_.pop_front();
    ++first_;
  }
  ++fresh_;
  oldest_fresh_ = std::min(oldest_fresh_, at);
}

TimePoint ArrivalReport::due_at() const {
  if (fresh_ == 0) return TimePoint::max();
  if (fresh_ >= kMany) return oldest_fresh_;
  return std::max(last_report_ + kInterval, oldest_fresh_);
}

protocol::Feedback ArrivalReport::take(TimePoint now) {
  protocol::Feedback feedback;
  feedback.time_us = static_cast<uint64_t>(to_microseconds(now.time_since_epoch()));
  const uint64_t end = first_ + arrivals_.size();
  uint64_t from = std::max(first_, begins_[0]);
  if (end - std::min(from, end) > protocol::kMaxReported) from = end - protocol::kMaxReported;
  feedback.first = from;
  for (uint64_t s = from; s < end; ++s) {
    const TimePoint arrived = arrivals_[static_cast<size_t>(s - first_)];
    feedback.ages[feedback.count++] = arrived == TimePoint{} ? uint16_t{0} : age_of(arrived, now);
  }
  begins_ = {begins_[1], reported_ + 1};
  reported_ = end - 1;
  fresh_ = 0;
  oldest_fresh_ = TimePoint::max();
  last_report_ = now;
  return feedback;
}

}  // namespace gnomon::client
