// Everything that a session's link to its client decides: what goes out next and when, what goes again, how much
// parity a frame gets, how fast, how long datagrams may be, and whether another view is worth rendering.
//
// Pure: no socket, no clock, no seal. The owner asks next() for a body, seals and sends it, says sent(), and comes
// back at wake_at(). One thread: the net thread that owns the session.
#pragma once

#include <deque>
#include <optional>
#include <utility>

#include "daemon/link/loss_detection.h"
#include "daemon/link/mtu_discovery.h"
#include "daemon/link/pacer.h"
#include "daemon/link/queue_delay.h"
#include "daemon/link/rate_controller.h"
#include "daemon/link/request_gate.h"
#include "daemon/link/stored_frame.h"
#include "protocol/datagram.h"

namespace gnomon::daemon {

struct Outgoing {
  protocol::DatagramKind kind = protocol::DatagramKind::frame_slice;
  std::span<const uint8_t> body;  // borrowed until the next call
};

// The first sending of a frame is over.
struct FrameEnd {
  FrameId frame;
  bool whole = false;  // else some of it came to nothing: its deadline was over, or newer frames took its place
};

// Since the session began.
struct LinkCounters {
  uint64_t sent = 0;  // datagrams
  uint64_t arrived = 0;
  uint64_t lost = 0;
  uint64_t retransmitted = 0;
  uint64_t parity = 0;      // sent
  uint64_t recovered = 0;   // slices, as the client says
  uint64_t incomplete = 0;  // frames, as the client says
  uint64_t too_late = 0;    // datagrams dropped because their frame had lost its use

  LinkCounters operator-(const LinkCounters& before) const {
    return {sent - before.sent,
            arrived - before.arrived,
            lost - before.lost,
            retransmitted - before.retransmitted,
            parity - before.parity,
            recovered - before.recovered,
            incomplete - before.incomplete,
            too_late - before.too_late};
  }
};

class LinkSender {
 public:
  // `features`: granted ones. Without kFeatureFeedback everything goes at once and nothing is known of the path.
  // `resumed`: the client has counted before.
  explicit LinkSender(uint64_t features, bool resumed = false);

  // A frame to send. Nothing of it goes after the deadline; max: the client has said none. Returns the bytes of its
  // datagrams, parity included.
  size_t add(const protocol::EncodedFrame& slices, TimePoint deadline, TimePoint now);

  void hear(const protocol::Feedback& feedback, TimePoint now);

  // The next body that may go now, retransmissions first. After it: sent().
  std::optional<Outgoing> next(TimePoint now);
  void sent(uint64_t sequence, size_t datagram_bytes, TimePoint now);
  TimePoint wake_at(TimePoint now) const;
  std::optional<FrameEnd> take_end();
  size_t take_extra_bytes() { return std::exchange(extra_bytes_, 0); }  // beside frames' first sending

  // A frame of which nothing is known to have arrived has lost its use: it may be made anew. True once a frame.
  bool take_lost(FrameId frame, TimePoint now);

  bool takes_view(TimePoint now);
  void view_taken(FrameId frame, TimePoint now) { gate_.asked(frame, now); }
  TimePoint takes_view_at(TimePoint now) const;

  size_t datagram_bytes() const { return mtu_.bytes(); }
  // Of a slice, with its header: parity needs some room too.
  size_t slice_body_bytes() const;

  double rate() const { return rate_.rate(); }
  double loss() const { return rate_.loss(); }
  Nanoseconds rtt() const { return loss_detection_.rtt(); }
  Nanoseconds queue_delay() const { return queue_.now(); }
  bool competing(TimePoint now) const { return rate_.competing(now); }
  const LinkCounters& counters() const { return counters_; }

 private:
  struct Item {
    uint64_t answer = 0;
    FrameId frame;
    Cargo cargo = Cargo::slice;
    uint16_t number = 0;
    size_t bytes = 0;
  };

  bool feedback() const { return (features_ & protocol::kFeatureFeedback) != 0; }
  bool parity() const { return (features_ & protocol::kFeatureParity) != 0; }
  bool worth_parity(TimePoint deadline, TimePoint now) const;
  void push(std::deque<Item>& queue, const Item& item);
  void pop(std::deque<Item>& queue);
  void pop_fresh(bool sent);
  StoredFrame* find(uint64_t answer);
  std::optional<Outgoing> offer(const Item& item, TimePoint now);
  void handle_losses(const std::vector<SentDatagram>& lost, TimePoint now);
  void handle_tail(const SentDatagram& tail, TimePoint now);
  void send_again(const SentDatagram& datagram, TimePoint now);  // if it can still arrive in time
  void handle_arrivals(const std::vector<Arrival>& arrived, TimePoint now);
  double delivered() const;
  double pace() const;
  void expire(TimePoint now);

  static constexpr size_t kFrames = 4;

  uint64_t features_;
  TimePoint newest_arrived_sent_{};
  bool counts_from_here_;  // what the client has counted until its next report is none of ours
  uint32_t recovered_before_ = 0, incomplete_before_ = 0;
  std::deque<StoredFrame> frames_;
  uint64_t answers_ = 0;
  std::optional<FrameId> made_anew_;  // the last one: its second answer goes without parity, as the first
  std::deque<Item> again_, fresh_;
  size_t backlog_ = 0;  // bytes of both
  double spread_rate_ = 0;
  size_t extra_bytes_ = 0;
  bool whole_ = true;  // the first of fresh_, so far
  std::deque<FrameEnd> ends_;
  std::optional<Item> offered_;  // by next()
  bool offered_again_ = false;   // from again_
  std::vector<uint8_t> probe_;
  bool limited_ = false;                                  // by the rate, since the last feedback
  Nanoseconds interval_ = std::chrono::milliseconds(16);  // between frames, smoothed
  TimePoint last_frame_{};

  Pacer pacer_;
  LossDetection loss_detection_;
  QueueDelay queue_;
  RateController rate_;
  MtuDiscovery mtu_;
  RequestGate gate_;
  struct Bytes {
    Nanoseconds arrived;  // the client's clock
    size_t bytes;
  };
  std::deque<Bytes> deliveries_;
  LinkCounters counters_;
};

}  // namespace gnomon::daemon
