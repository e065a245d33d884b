// A session in virtual time: the client sends cameras at a steady rate, a renderer answers after a while, and the real
// LinkSender, ArrivalReport, SliceRecovery and FrameAssembler communicate over simulated links.
#pragma once

#include <optional>
#include <random>

#include "client/net/arrival_report.h"
#include "client/stream/frame_assembler.h"
#include "client/stream/slice_recovery.h"
#include "daemon/link/link_sender.h"
#include "daemon/link/omitted_numbers.h"
#include "tests/tools/netsim/link.h"
#include "tests/unit/link/event_queue.h"

namespace gnomon::tests {

struct SessionPlan {
  double rate_hz = 60;
  TileGrid grid{256, 128, 2};
  double busy = 0.2;  // share of words that do not compress; the frame's size grows with it
  Nanoseconds render = std::chrono::milliseconds(5);
  Nanoseconds deadline{};  // of a frame, from its camera's arrival; 0: none
  uint64_t features = protocol::kFeatureFeedback | protocol::kFeatureParity;
  TimePoint start{std::chrono::seconds(1)};
  bool longer_slices = false;  // slices get longer as far as the path carries them
  Nanoseconds path_delay{};    // of the link without queueing, jitter included
};

// The state of a frame when the next frame should have arrived completely ("within one further frame").
struct Look {
  TimePoint at{};
  FrameId frame;
  double fresh = 0;  // share of words that are of this frame or a newer one
};

class SimulatedSession {
 public:
  SimulatedSession(EventQueue& events, netsim::Link& up, netsim::Link& down, const SessionPlan& plan);

  const daemon::LinkSender& link() const { return link_; }
  const std::vector<Look>& looks() const { return looks_; }
  uint64_t asked() const { return asked_; }
  uint64_t delivered_bytes() const { return delivered_; }
  uint64_t complete() const { return complete_; }
  uint64_t recovered() const { return recovered_; }
  size_t frame_bytes() const { return slices_.bytes.size(); }

  // Times that this session's datagrams waited in the bottleneck's queue.
  const std::vector<Nanoseconds>& waits() const { return waits_; }

  double fresh_share(TimePoint from, TimePoint to) const;
  Nanoseconds longest_gap(TimePoint from, TimePoint to) const;  // between looks
  Nanoseconds wait_percentile(double share) const;
  void forget_waits() { waits_.clear(); }

 private:
  using Bytes = std::vector<uint8_t>;

  void ask();
  void answer();
  void rendered(FrameId frame, TimePoint deadline);
  void pump();
  void wake(TimePoint when);
  void carry(const daemon::Outgoing& out);
  void receive(uint64_t sequence, protocol::DatagramKind kind, const Bytes& body);
  void add_slice(const Bytes& body);
  void report();
  void look(FrameId frame);

  EventQueue& events_;
  netsim::Link& up_;
  netsim::Link& down_;
  SessionPlan plan_;
  protocol::EncodedMask slices_;
  daemon::LinkSender link_;
  size_t body_bytes_;  // of the longest slice
  daemon::OmittedNumbers omitted_{[random = std::mt19937_64(3)]() mutable { return random(); }};
  uint64_t sequence_ = 0;
  std::optional<FrameId> waiting_;  // newest camera that is not rendered yet
  TimePoint waiting_deadline_{};
  TimePoint next_wake_ = TimePoint::max();

  uint64_t asked_ = 0;
  client::ArrivalReport arrivals_;
  client::SliceRecovery recovery_;
  client::FrameAssembler assembler_;
  TimePoint next_report_ = TimePoint::max();
  std::vector<FrameId> newest_;           // of each word
  std::map<FrameId, TimePoint> through_;  // when all of the frame's datagrams should have arrived
  std::vector<Look> looks_;
  std::vector<Nanoseconds> waits_;
  uint64_t delivered_ = 0, complete_ = 0, recovered_ = 0;
};

}  // namespace gnomon::tests
