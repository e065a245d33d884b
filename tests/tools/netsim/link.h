// The core of the simulator: it decides for each packet of one direction of a link when it arrives, if at all. A pure
// function of the seed, the packets' sizes and the times at which they are sent; no sockets, no clock. Tests run it in
// virtual time.
//
// The link is one transmitter of limited rate with a first-in, first-out queue before it, then a delay line. All
// flows that are sent through one Link share its bottleneck.
#pragma once

#include <array>
#include <span>

#include "tests/tools/netsim/profile.h"

namespace gnomon::netsim {

struct Fate {
  enum class Kind { arrives, lost, queue_full, blocked };
  Kind kind = Kind::arrives;
  std::array<TimePoint, 2> at{};  // of the packet, and of its duplicate
  uint32_t copies = 0;            // number that arrive
  Nanoseconds queued{};           // time in the queue before the transmitter
  std::span<const TimePoint> arrivals() const { return std::span(at).first(copies); }
};

class Link {
 public:
  // `start`: time 0 of the schedule.
  Link(Schedule schedule, uint64_t seed, TimePoint start);

  // Precondition: times of successive calls do not decrease.
  Fate send(size_t bytes, TimePoint now);

  // As send(), for a datagram, which is blocked if the link takes none or none of that length.
  Fate send_datagram(size_t bytes, TimePoint now);

  // How long a packet that is sent now would wait in the queue.
  Nanoseconds backlog(TimePoint now) const { return std::max(Nanoseconds{}, busy_until_ - now); }

 private:
  const Profile& profile(TimePoint now) const;
  bool chance(double share);
  double uniform();  // at least 0, below 1
  bool loses(const Profile& profile);
  bool fits(const Profile& profile, Nanoseconds wait, size_t bytes) const;
  TimePoint arrival(const Profile& profile, TimePoint left);

  Schedule schedule_;
  TimePoint start_;
  uint64_t random_;
  bool bad_ = false;        // within a burst of losses
  TimePoint busy_until_;    // of the transmitter
  TimePoint last_arrival_;  // of a packet in order
};

}  // namespace gnomon::netsim
