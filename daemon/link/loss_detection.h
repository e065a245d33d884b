// Tracks each datagram sent to a client until it is acknowledged with its arrival time, or lost. Pure.
//
// A datagram counts as lost when a little more than a round trip has passed and a datagram has arrived that was sent at
// least three after it, or well after it in time (RFC 9002, 6.1: packet and time threshold). If nothing that was sent
// after a datagram arrives, the newest unacknowledged one should be sent again after a timeout: the Feedback on it then
// reveals the other losses (a tail probe: RFC 9002, 6.2). A datagram that arrives after it was declared lost is
// reported as arrived as well.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "common/clock.h"
#include "common/ids.h"
#include "protocol/feedback.h"

namespace gnomon::daemon {

enum class Cargo : uint8_t { slice, parity, probe };

struct SentDatagram {
  TimePoint at{};
  uint32_t bytes = 0;  // of the UDP payload
  Cargo cargo = Cargo::slice;
  uint64_t answer = 0;  // LinkSender's number of the frame, from 1; one camera can be answered twice
  uint16_t number = 0;  // index of the slice, or of the parity datagram, within the frame
};

struct Arrival {
  SentDatagram sent;
  Nanoseconds one_way{};  // client's clock at arrival minus ours at sending: only differences are meaningful
};

// What one Feedback reported for the first time.
struct PathUpdate {
  std::vector<Arrival> arrived;  // in the order of sending
  std::vector<SentDatagram> lost;
  Nanoseconds rtt{};  // of the newest arrival, without the client's delay before the Feedback; 0 if not measured
};

class LossDetection {
 public:
  // Sequence numbers count up by one; another number starts afresh (a resumed session).
  void sent(uint64_t sequence, const SentDatagram& datagram);

  PathUpdate take(const protocol::Feedback& feedback, TimePoint now);
  // Returns the newest unacknowledged datagram once tail_due() has passed, and marks it as lost; nullopt otherwise.
  std::optional<SentDatagram> take_tail(TimePoint now);
  TimePoint tail_due() const;  // TimePoint::max() if every datagram is acknowledged or lost

  Nanoseconds rtt() const { return smoothed_; }  // smoothed; 0 if not measured yet

  // How long nothing has arrived; 0 if fewer than kLaterOnes datagrams were sent since the newest arrival.
  Nanoseconds silence(TimePoint now) const;

 private:
  enum class State : uint8_t { flying, arrived, lost };
  struct Entry {
    SentDatagram datagram;
    State state = State::flying;
  };

  static constexpr size_t kMaxEntries = 1 << 14;
  static constexpr uint64_t kLaterOnes = 3;

  Entry* find(uint64_t sequence);
  bool is_lost(const Entry& entry, uint64_t sequence, TimePoint now) const;
  void find_losses(TimePoint now, std::vector<SentDatagram>& lost);
  void measure(Nanoseconds rtt);
  void settle();
  Nanoseconds rtt_or_guess() const;
  Nanoseconds tail_patience() const;

  std::deque<Entry> entries_;
  uint64_t first_ = 1;   // sequence of entries_.front()
  uint64_t newest_ = 0;  // highest sequence that arrived
  TimePoint newest_sent_{};
  uint64_t unsettled_ = 1;  // every earlier sequence has arrived or is lost
  uint64_t unheard_ = 0;    // number of datagrams sent after the newest arrival
  TimePoint silent_since_{};
  TimePoint last_tail_{};
  uint32_t tails_ = 0;  // tail probes since the newest arrival
  Nanoseconds smoothed_{}, variance_{};
};

}  // namespace gnomon::daemon
