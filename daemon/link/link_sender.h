// Congestion control and reliability of a session's link: which datagram goes next and when, what is retransmitted, how
// much parity a frame gets, the sending rate, the datagrams' length, and whether another view is worth rendering.
//
// Pure: no socket, no clock, no seal. The owner takes a body from next(), seals and sends it, calls sent(), and calls
// next() again at wake_at(). One thread: the net thread that owns the session.
#pragma once

#include <optional>
#include <utility>

#include "daemon/link/delivery_rate.h"
#include "daemon/link/feedback_allowance.h"
#include "daemon/link/frame_spread.h"
#include "daemon/link/loss_detection.h"
#include "daemon/link/mtu_discovery.h"
#include "daemon/link/pacer.h"
#include "daemon/link/queue_delay.h"
#include "daemon/link/rate_controller.h"
#include "daemon/link/request_gate.h"
#include "daemon/link/send_queue.h"
#include "daemon/link/sent_slices.h"
#include "daemon/link/stored_frames.h"
#include "protocol/datagram.h"

namespace gnomon::daemon {

struct Outgoing {
  protocol::DatagramKind kind = protocol::DatagramKind::frame_slice;
  std::span<const uint8_t> body;  // borrowed until the next call
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

enum class FeedbackVerdict {
  taken,
  // The others have no effect.
  too_many,  // the client has used up its allowance
  invented,  // it reports the arrival of a datagram that was never sent: its client is not to be believed (RFC 9000,
             // 13.1)
};

class LinkSender {
 public:
  // `features`: the granted ones. Without kFeatureFeedback every datagram goes at once and nothing is known of the path.
  // `resumed_after`, of a resumed session: the newest sequence number of the server before; the client's counters began
  // there too.
  explicit LinkSender(uint64_t features, std::optional<uint64_t> resumed_after = std::nullopt);

  // Queues a frame. None of its datagrams is sent after `deadline`; TimePoint::max() if the client has named none.
  // Returns the bytes of its datagrams, parity included.
  size_t add(const protocol::EncodedMask& slices, TimePoint deadline, TimePoint now);

  // Of clients with kFeatureWebTransport: QUIC has told that a datagram has arrived, or is lost.
  void on_outcome(uint64_t sequence, bool arrived, TimePoint now);
  static constexpr size_t kMostWebTransportBody = 1140;  // bytes of a slice that such a client may be sent

  FeedbackVerdict on_feedback(const protocol::Feedback& feedback, TimePoint now);

  // Datagrams go to another host from now on: what is known of the path is forgotten. Reports of what was sent before
  // still tell what has arrived, but nothing of the new path.
  void begin_path(TimePoint now);

  // The next body that may be sent now, retransmissions first; nullopt if there is none. sent() follows it.
  std::optional<Outgoing> next(TimePoint now);
  // Also of datagrams that next() has not offered. Sequence numbers increase from call to call, omitted() included.
  void sent(uint64_t sequence, size_t datagram_bytes, TimePoint now);
  void omitted(uint64_t sequence);  // no datagram has this number, nor will have it
  TimePoint wake_at(TimePoint now) const;
  std::optional<FrameEnd> take_end() { return queue_.take_end(); }
  // Bytes of retransmissions and probes since the last call: what was sent beside the frames' first sending.
  size_t take_extra_bytes() { return std::exchange(extra_bytes_, 0); }

  // True, once a frame, if no slice of the frame is known to have arrived and none can arrive in time any more: its
  // camera may be answered by a second frame.
  bool take_lost(FrameId frame, TimePoint now);

  bool may_request(TimePoint now);
  void on_request(FrameId frame, TimePoint now) { gate_.on_request(frame, now); }
  TimePoint may_request_at(TimePoint now) const;

  size_t datagram_bytes() const { return mtu_.bytes(); }
  // The longest body of a slice, with its header, that leaves room for parity's overhead.
  size_t slice_body_bytes() const;

  double rate() const { return rate_.rate(); }  // bytes a second
  Nanoseconds rtt() const { return loss_detection_.rtt(); }
  Nanoseconds queue_delay() const { return queue_delay_.current(); }
  const LinkCounters& counters() const { return counters_; }

 private:
  std::optional<Outgoing> offer(const QueuedDatagram& datagram, TimePoint now);
  void handle_losses(const std::vector<SentDatagram>& lost, TimePoint now);
  void send_again(const SentDatagram& datagram, TimePoint now);  // if it can still arrive in time
  void handle_arrivals(const std::vector<Arrival>& arrived, TimePoint now);

  bool feedback_, parity_, web_transport_;  // the features
  TimePoint newest_arrived_sent_{};
  TimePoint path_began_{};
  // A link that begins in the middle of a session: the client's counters have run before, so that its first report is
  // what later ones are counted from.
  bool counts_from_here_;
  uint32_t recovered_before_ = 0, incomplete_before_ = 0;
  StoredFrames frames_;
  SendQueue queue_;
  std::optional<FrameId>
      answered_twice_;  // the last such frame: its second answer goes without parity, as the first
  double spread_rate_ = 0;
  size_t extra_bytes_ = 0;
  std::optional<QueuedDatagram> offered_;  // by next()
  std::vector<uint8_t> probe_;
  bool limited_ = false;                                  // by the rate, since the last feedback
  Nanoseconds interval_ = std::chrono::milliseconds(16);  // between frames, smoothed
  TimePoint last_frame_{};

  Pacer pacer_;
  FrameSpread spread_;
  LossDetection loss_detection_;
  SentSlices sent_slices_;
  QueueDelay queue_delay_;
  RateController rate_;
  MtuDiscovery mtu_;
  RequestGate gate_;
  DeliveryRate delivery_;
  FeedbackAllowance allowance_;
  LinkCounters counters_;
};

}  // namespace gnomon::daemon
