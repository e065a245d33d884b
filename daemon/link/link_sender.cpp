#include "daemon/link/link_sender.h"

#include <algorithm>

#include "daemon/link/parity_plan.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using protocol::DatagramKind;

constexpr Nanoseconds kSilence = 200ms;  // beyond four round trips
constexpr double kPlenty = 2;            // a rate of this many times what is sent leaves room for padding
constexpr size_t kSealBytes = protocol::kHeaderBytes + protocol::kTagBytes;

DatagramKind kind_of(Cargo cargo) {
  switch (cargo) {
    case Cargo::slice: return DatagramKind::frame_slice;
    case Cargo::parity: return DatagramKind::frame_parity;
    case Cargo::probe: return DatagramKind::probe;
  }
  return DatagramKind::probe;
}

// Retransmission costs less than parity, where there is time for it.
bool worth_parity(double loss, Nanoseconds rtt, Nanoseconds time) {
  return loss >= kLeastLoss && rtt + rtt / 8 + rtt / 2 + 2 * std::chrono::milliseconds(10) > time;
}

}  // namespace

LinkSender::LinkSender(uint64_t features, std::optional<uint64_t> resumed_after)
    : feedback_((features & protocol::kFeatureFeedback) != 0),
      parity_((features & protocol::kFeatureParity) != 0),
      web_transport_((features & protocol::kFeatureWebTransport) != 0),
      counts_from_here_(resumed_after.has_value()),
      loss_detection_(resumed_after.value_or(0)) {}

size_t LinkSender::slice_body_bytes() const {
  const size_t body = datagram_bytes() - kSealBytes - (parity_ ? protocol::kParityOverhead : 0);
  return web_transport_ ? std::min(body, kMostWebTransportBody) : body;
}

size_t LinkSender::add(const protocol::EncodedMask& slices, TimePoint deadline, TimePoint now) {
  if (slices.slices.empty()) return 0;
  const size_t before = queue_.bytes();
  if (last_frame_ != TimePoint{}) interval_ += (std::min<Nanoseconds>(now - last_frame_, 200ms) - interval_) / 8;
  last_frame_ = now;
  frames_.drop_expired(now);
  const bool pad = feedback_ && rate() > kPlenty * static_cast<double>(slices.bytes.size()) / to_seconds(interval_);
  StoredFrame& frame = frames_.add(slices, deadline, pad);
  gate_.on_answer(frame.frame(), frame.bytes(), now);
  const Nanoseconds time = deadline == TimePoint::max() ? 2 * interval_ : deadline - now;
  if (parity_ && answered_twice_ != frame.frame() && worth_parity(rate_.loss(), rtt(), time)) {
    frame.protect(std::min(0.4, rate_.loss()));
  }
  for (uint16_t i = 0; i < frame.slice_count(); ++i) {
    queue_.push({frame.answer(), frame.frame(), Cargo::slice, i, frame.body(i).size() + kSealBytes});
  }
  for (uint16_t i = 0; i < frame.parity_count(); ++i) {
    queue_.push({frame.answer(), frame.frame(), Cargo::parity, i, frame.parity_body(i).size() + kSealBytes});
  }
  spread_rate_ = static_cast<double>(queue_.bytes()) / to_seconds(std::min(spread_.current(), interval_ / 2));
  return queue_.bytes() - before;
}

// nullopt if the frame was dropped or can no longer arrive in time.
std::optional<Outgoing> LinkSender::offer(const QueuedDatagram& datagram, TimePoint now) {
  const StoredFrame* frame = frames_.find(datagram.answer);
  if (!frame || now >= frame->useful_until()) {
    ++counters_.too_late;
    return std::nullopt;
  }
  offered_ = datagram;
  const bool parity = datagram.cargo == Cargo::parity;
  return Outgoing{kind_of(datagram.cargo),
                  parity ? frame->parity_body(datagram.number) : frame->body(datagram.number)};
}

std::optional<Outgoing> LinkSender::next(TimePoint now) {
  offered_.reset();
  if (const auto tail = loss_detection_.take_tail(now)) {
    // The datagram may have arrived, so that no counter takes it for lost.
    if (tail->cargo == Cargo::probe)
      mtu_.probe_lost(now);
    else
      send_again(*tail, now);
  }
  if (feedback_ && !pacer_.may_send(now)) {
    limited_ = limited_ || (queue_.bytes() > 0 && rate() <= spread_rate_);
    return std::nullopt;
  }
  if (feedback_) {
    if (const auto size = mtu_.probe_due(now); size && rtt().count() > 0) {
      probe_.assign(*size - kSealBytes, 0);
      offered_ = {.cargo = Cargo::probe, .bytes = *size};
      return Outgoing{DatagramKind::probe, probe_};
    }
  }
  for (const QueuedDatagram* front; (front = queue_.front()); queue_.pop(front->again, false)) {
    if (auto out = offer(*front, now)) return out;
  }
  return std::nullopt;
}

void LinkSender::sent(uint64_t sequence, size_t datagram_bytes, TimePoint now) {
  ++counters_.sent;
  allowance_.sent();
  if (!offered_) {
    if (feedback_) loss_detection_.sent_beside(sequence);
    return;
  }
  const QueuedDatagram datagram = *offered_;
  offered_.reset();
  if (datagram.cargo == Cargo::probe) {
    mtu_.probe_sent(now);
    extra_bytes_ += datagram_bytes;
  } else if (datagram.again) {
    queue_.pop(true, true);
    ++counters_.retransmitted;
    extra_bytes_ += datagram_bytes;
  } else {
    if (StoredFrame* frame = frames_.find(datagram.answer)) frame->sent(now);
    counters_.parity += datagram.cargo == Cargo::parity;
    queue_.pop(false, true);
  }
  if (web_transport_) sent_slices_.add(sequence, datagram.answer, datagram.number);
  if (!feedback_) return;
  // A probe is no part of a frame: at the pace that spreads a small one, a long probe would hold up several.
  const bool is_probe = datagram.cargo == Cargo::probe;
  const double pace = is_probe ? rate() : std::min(rate(), std::max(spread_rate_, RateController::kLeastRate));
  pacer_.sent(datagram_bytes, pace, now);
  loss_detection_.sent(sequence, {.at = now,
                                  .bytes = static_cast<uint32_t>(datagram_bytes),
                                  .cargo = datagram.cargo,
                                  .answer = datagram.answer,
                                  .number = datagram.number});
}

void LinkSender::omitted(uint64_t sequence) {
  if (feedback_) loss_detection_.omitted(sequence);
}

void LinkSender::begin_path(TimePoint now) {
  path_began_ = now;
  pacer_ = {};
  queue_delay_ = {};
  spread_ = {};
  rate_ = {};
  mtu_ = {};
  delivery_ = {};
  limited_ = false;
  loss_detection_.begin_path(now);
}

FeedbackVerdict LinkSender::on_feedback(const protocol::Feedback& said, TimePoint now) {
  if (!allowance_.take(now)) return FeedbackVerdict::too_many;
  if (loss_detection_.is_invented(said)) return FeedbackVerdict::invented;
  if (std::exchange(counts_from_here_, false)) {
    recovered_before_ = said.recovered;
    incomplete_before_ = said.incomplete;
  }
  counters_.recovered +=
      static_cast<uint32_t>(said.recovered - recovered_before_ - static_cast<uint32_t>(counters_.recovered));
  counters_.incomplete +=
      static_cast<uint32_t>(said.incomplete - incomplete_before_ - static_cast<uint32_t>(counters_.incomplete));
  const PathUpdate update = loss_detection_.take(said, now);
  handle_arrivals(update.arrived, now);
  handle_losses(update.lost, now);
  PathReport report;
  report.rtt = loss_detection_.rtt();
  report.queue = queue_delay_.current();
  report.delivered = delivery_.bytes_per_second();
  for (const Arrival& arrival : update.arrived) report.arrived += arrival.sent.at >= path_began_;
  for (const SentDatagram& datagram : update.lost) {
    report.lost += datagram.cargo != Cargo::probe && datagram.at >= path_began_;
  }
  report.newest_sent = newest_arrived_sent_;
  report.limited = std::exchange(limited_, false);
  if (report.lost > 0 || (report.arrived > 0 && queue_delay_.known())) spread_.observe(report.lost, report.queue);
  rate_.observe(report, now);
  return FeedbackVerdict::taken;
}

void LinkSender::handle_arrivals(const std::vector<Arrival>& arrived, TimePoint now) {
  for (const Arrival& a : arrived) {
    ++counters_.arrived;
    StoredFrame* frame = frames_.find(a.sent.answer);
    if (frame && a.sent.cargo == Cargo::slice) frame->slice_arrived(a.sent.number);
    if (a.sent.at < path_began_) continue;
    newest_arrived_sent_ = std::max(newest_arrived_sent_, a.sent.at);
    queue_delay_.add(a.one_way, now);
    delivery_.arrived(a.sent.at + a.one_way, a.sent.bytes);
    if (a.sent.cargo == Cargo::probe) {
      mtu_.probe_arrived(a.sent.bytes, now);
      continue;
    }
    mtu_.arrived(a.sent.bytes);
  }
}

void LinkSender::handle_losses(const std::vector<SentDatagram>& lost, TimePoint now) {
  for (const SentDatagram& datagram : lost) {
    const bool of_path = datagram.at >= path_began_;
    if (datagram.cargo == Cargo::probe) {
      if (of_path) mtu_.probe_lost(now);
      continue;
    }
    ++counters_.lost;
    if (of_path) mtu_.lost(datagram.bytes, now);
    send_again(datagram, now);
  }
}

void LinkSender::on_outcome(uint64_t sequence, bool arrived, TimePoint now) {
  const auto slice = sent_slices_.take(sequence);
  if (!slice) return;
  ++(arrived ? counters_.arrived : counters_.lost);
  if (!arrived) return send_again({.cargo = Cargo::slice, .answer = slice->answer, .number = slice->number}, now);
  if (StoredFrame* const frame = frames_.find(slice->answer)) frame->slice_arrived(slice->number);
}

void LinkSender::send_again(const SentDatagram& datagram, TimePoint now) {
  StoredFrame* frame = frames_.find(datagram.answer);
  if (!frame) return;
  if (datagram.cargo == Cargo::parity) return frame->parity_lost(datagram.number);
  const bool in_time = now + rtt() / 2 < frame->useful_until();
  if (frame->slice_lost(datagram.number) && in_time) {
    queue_.push({datagram.answer, frame->frame(), Cargo::slice, datagram.number, datagram.bytes, true});
  }
}

TimePoint LinkSender::wake_at(TimePoint now) const {
  if (!feedback_) return queue_.bytes() > 0 ? now : TimePoint::max();
  // Waiting for kBatch lets several datagrams go by one system call.
  const TimePoint paced = queue_.bytes() > 0 ? std::max(now + Pacer::kBatch, pacer_.next()) : TimePoint::max();
  return std::min(paced, loss_detection_.tail_due());
}

bool LinkSender::take_lost(FrameId frame, TimePoint now) {
  const StoredFrame* newest = frames_.newest();
  if (!feedback_ || !newest) return false;
  // Parity of one answer and slices of another would rebuild nonsense, should some have arrived unreported.
  if (newest->frame() != frame || newest->parity_count() > 0) return false;
  if (newest->any_arrived() || now < newest->useful_until()) return false;
  frames_.drop_newest();
  answered_twice_ = frame;
  return true;
}

// The frame that answers the view is cut into datagrams of the length that holds now.
bool LinkSender::may_request(TimePoint now) {
  if (feedback_ && loss_detection_.silence(now) > 4 * rtt() + kSilence) mtu_.silent(now);
  if (!feedback_) {  // not while a frame has not begun to go, as on a connection without room
    const StoredFrame* const newest = frames_.newest();
    return !newest || queue_.bytes() <= newest->bytes();
  }
  if (gate_.open(queue_.bytes(), rate(), now)) return true;
  limited_ = true;
  return false;
}

TimePoint LinkSender::may_request_at(TimePoint now) const {
  return feedback_ ? gate_.opens_at(queue_.bytes(), rate(), now) : now;
}

}  // namespace gnomon::daemon
