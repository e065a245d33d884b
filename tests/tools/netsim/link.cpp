#include "tests/tools/netsim/link.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace gnomon::netsim {

Link::Link(Schedule schedule, uint64_t seed, TimePoint start)
    : schedule_(std::move(schedule)), start_(start), random_(seed), busy_until_(start), last_arrival_(start) {
  assert(!schedule_.empty());
}

Fate Link::send(size_t bytes, TimePoint now) {
  const Profile& is = profile(now);
  Fate fate;
  // Every packet that the queue takes draws equally many random numbers, lost or not, so that a change of one property
  // does not shift those of the others.
  const bool lost = loses(is);
  const bool twice = chance(is.duplicate);
  fate.queued = backlog(now);
  if (!fits(is, fate.queued, bytes)) {
    fate.kind = Fate::Kind::queue_full;
    return fate;
  }
  TimePoint left = now;
  if (is.rate_bit_per_s > 0) {
    const double seconds = static_cast<double>(bytes) * 8 / is.rate_bit_per_s;
    left = now + fate.queued + Nanoseconds(static_cast<int64_t>(std::ceil(seconds * 1e9)));
    busy_until_ = left;
  }
  const TimePoint there = arrival(is, left);
  if (lost) {  // on the way, after the transmitter, whose time it has taken
    fate.kind = Fate::Kind::lost;
    return fate;
  }
  fate.at = {there, there};
  fate.copies = twice ? 2 : 1;
  return fate;
}

Fate Link::send_datagram(size_t bytes, TimePoint now) {
  const Profile& is = profile(now);
  if (is.udp && (is.mtu == 0 || bytes <= is.mtu)) return send(bytes, now);
  Fate fate;
  fate.kind = Fate::Kind::blocked;
  return fate;
}

const Profile& Link::profile(TimePoint now) const {
  const auto next = std::upper_bound(schedule_.begin(), schedule_.end(), now - start_,
                                     [](Nanoseconds at, const Phase& phase) { return at < phase.from; });
  return next == schedule_.begin() ? next->profile : std::prev(next)->profile;
}

// SplitMix64 (Steele, Lea and Flood, OOPSLA 2014): the same on every machine, which std's distributions are not.
double Link::uniform() {
  random_ += 0x9e3779b97f4a7c15;
  uint64_t z = random_;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

bool Link::chance(double share) { return uniform() < share; }

bool Link::loses(const Profile& is) {
  const bool turns = chance(bad_ ? is.burst_leave : is.burst_enter);
  bad_ = bad_ != turns;
  return chance(is.loss) || bad_;
}

bool Link::fits(const Profile& is, Nanoseconds wait, size_t bytes) const {
  if (is.rate_bit_per_s <= 0) return true;
  const double waiting_bytes = to_seconds(wait) * is.rate_bit_per_s / 8;
  return wait <= is.queue &&
         (is.queue_bytes == 0 || waiting_bytes + static_cast<double>(bytes) <= static_cast<double>(is.queue_bytes));
}

TimePoint Link::arrival(const Profile& is, TimePoint left) {
  const double swing = (2 * uniform() - 1) * static_cast<double>(is.jitter.count());
  const Nanoseconds delay = std::max(Nanoseconds{}, is.delay + Nanoseconds(static_cast<int64_t>(swing)));
  if (chance(is.reorder)) return left + delay + is.reorder_by;
  last_arrival_ = std::max(last_arrival_, left + delay);
  return last_arrival_;
}

}  // namespace gnomon::netsim
