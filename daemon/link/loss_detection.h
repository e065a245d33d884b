// Tracks each datagram sent to a client until it is acknowledged with its arrival time, or lost. Pure.
//
// A datagram counts as lost when a little more than a round trip has passed and a datagram has arrived that was sent at
// least three after it, or well after it in time (RFC 9002, 6.1: packet and time threshold). If nothing that was sent
// after a datagram arrives, the newest unacknowledged one should be sent again after a timeout: the Feedback on it then
// reveals the other losses (a tail probe: RFC 9002, 6.2). A datagram that arrives after it was declared lost is
// reported as arrived as well. Sequence numbers that were left out, or used for something else, count for nothing.
#pragma once

#include <deque>
#include <optional>
#include <vector>

#include "common/clock.h"
#include "common/ids.h"
#include "daemon/link/client_clock.h"
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
  Nanoseconds
      one_way{};  // client's clock at arrival minus ours at sending: only differences are meaningful; bounded
};

// What one Feedback reported for the first time.
struct PathUpdate {
  std::vector<Arrival> arrived;  // in the order of sending
  std::vector<SentDatagram> lost;
  Nanoseconds rtt{};  // of the newest arrival, without the client's delay before the Feedback; 0 if not measured
};

class LossDetection {
 public:
  // `taken`: the newest sequence number that is in use already (of a resumed session).
  explicit LossDetection(uint64_t taken = 0) : first_(taken + 1), unsettled_(taken + 1) {}

  // Sequence numbers increase from call to call, over all three.
  void sent(uint64_t sequence, const SentDatagram& datagram);
  void sent_beside(uint64_t sequence);  // of a datagram whose arrival is of no interest, such as a Pong
  void omitted(uint64_t sequence);      // no datagram has this number, nor will have it

  // True if the Feedback reports the arrival of a datagram that was never sent. Arrivals of what was sent too long ago
  // to be remembered are not judged.
  bool is_invented(const protocol::Feedback& feedback) const;

  // The path is another one from now on: its round trip is not known, and what was sent before does not measure it.
  void begin_path(TimePoint now);

  PathUpdate take(const protocol::Feedback& feedback, TimePoint now);
  // Returns the newest unacknowledged datagram once tail_due() has passed, and marks it as lost; nullopt otherwise.
  std::optional<SentDatagram> take_tail(TimePoint now);
  TimePoint tail_due() const;  // TimePoint::max() if every datagram is acknowledged or lost

  Nanoseconds rtt() const { return smoothed_; }  // smoothed; 0 if not measured yet

  // How long nothing has arrived; 0 if fewer than kLaterOnes datagrams were sent since the newest arrival.
  Nanoseconds silence(TimePoint now) const;

 private:
  enum class State : uint8_t { flying, arrived, lost, beside, omitted };
  struct Entry {
    SentDatagram datagram = {};
    State state = State::flying;
    uint64_t ordinal = 0;  // datagrams tracked so far, this one included: unlike sequence numbers without gaps
  };

  static constexpr size_t kMaxEntries = 1 << 14;
  static constexpr uint64_t kLaterOnes = 3;

  Entry* find(uint64_t sequence);
  bool remembers(uint64_t sequence) const { return sequence >= first_ && sequence < end(); }
  uint64_t end() const { return first_ + entries_.size(); }  // no higher number has been used
  void append(uint64_t sequence, const Entry& entry);
  bool is_lost(const Entry& entry, TimePoint now) const;
  void find_losses(TimePoint now, std::vector<SentDatagram>& lost);
  void measure(Nanoseconds rtt);
  void settle();
  Nanoseconds rtt_or_guess() const;
  Nanoseconds tail_patience() const;

  std::deque<Entry> entries_;
  ClientClock clock_;
  uint64_t first_;       // sequence of entries_.front()
  uint64_t newest_ = 0;  // highest sequence that arrived
  uint64_t newest_ordinal_ = 0;
  TimePoint newest_sent_{};
  uint64_t unsettled_;    // every earlier sequence has arrived, is lost or counts for nothing
  uint64_t tracked_ = 0;  // number of datagrams
  uint64_t unheard_ = 0;  // of them, sent after the newest arrival
  TimePoint last_sent_{};
  TimePoint path_began_{};
  TimePoint silent_since_{};
  TimePoint last_tail_{};
  uint32_t tails_ = 0;  // tail probes since the newest arrival
  Nanoseconds smoothed_{}, variance_{};
};

}  // namespace gnomon::daemon
