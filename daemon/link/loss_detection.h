// What was sent to a client and what became of it: acknowledged with its arrival time, or lost. Pure.
//
// A datagram counts as lost when a little more than a round trip has passed and three sent after it have arrived, or
// one sent well after it (RFC 9002, 6.1: packet and time threshold). Where nothing arrives after it to tell, the last
// one is taken for lost and should go again: its arrival then tells of the others (a tail probe: RFC 9002, 6.2). One
// that arrives after all is reported as arrived too.
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
  uint64_t answer = 0;  // to the client's cameras, counted from 1: a camera can be answered twice
  uint16_t number = 0;  // of the slice, or of the parity's group
};

struct Arrival {
  SentDatagram sent;
  Nanoseconds one_way{};  // the client's clock at arrival minus ours at sending: differences mean something
};

// What one Feedback told that was not known before.
struct PathUpdate {
  std::vector<Arrival> arrived;  // in the order of sending
  std::vector<SentDatagram> lost;
  Nanoseconds rtt{};  // of the newest that arrived, without the client's waiting; 0: none arrived
};

class LossDetection {
 public:
  // Sequences count up by one.
  void sent(uint64_t sequence, const SentDatagram& datagram);

  PathUpdate take(const protocol::Feedback& feedback, TimePoint now);
  // The newest datagram, if nothing was heard of it for too long; nullopt otherwise.
  std::optional<SentDatagram> take_tail(TimePoint now);
  TimePoint tail_due() const;

  Nanoseconds rtt() const { return smoothed_; }  // 0 if it is not known

  // How long nothing has arrived although several datagrams were sent; 0 if too few were sent to tell.
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
  uint64_t newest_ = 0;  // highest that arrived
  TimePoint newest_sent_{};
  uint64_t unsettled_ = 1;  // all before are arrived or lost
  uint64_t unheard_ = 0;    // sent after the newest that arrived
  TimePoint silent_since_{};
  TimePoint last_tail_{};
  uint32_t tails_ = 0;  // since something arrived
  Nanoseconds smoothed_{}, variance_{};
};

}  // namespace gnomon::daemon
