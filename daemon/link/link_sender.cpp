#include "daemon/link/link_sender.h"

#include <algorithm>

#include "daemon/link/parity_plan.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using protocol::DatagramKind;

constexpr Nanoseconds kLongestSpread = 4ms;  // of a frame's datagrams, where the rate allows more
constexpr Nanoseconds kDeliveredOver = 100ms;
constexpr Nanoseconds kSilence = 200ms;  // beyond four round trips
constexpr double kPlenty = 2;            // a rate of so many times what is sent leaves room for padding
constexpr size_t kSealBytes = protocol::kHeaderBytes + protocol::kTagBytes;

DatagramKind kind_of(Cargo cargo) {
  switch (cargo) {
    case Cargo::slice: return DatagramKind::frame_slice;
    case Cargo::parity: return DatagramKind::frame_parity;
    case Cargo::probe: return DatagramKind::probe;
  }
  return DatagramKind::probe;
}

}  // namespace

LinkSender::LinkSender(uint64_t features, bool resumed) : features_(features), counts_from_here_(resumed) {}

size_t LinkSender::slice_body_bytes() const {
  return datagram_bytes() - kSealBytes - (parity() ? protocol::kParityOverhead : 0);
}

size_t LinkSender::add(const protocol::EncodedFrame& slices, TimePoint deadline, TimePoint now) {
  if (slices.slices.empty()) return 0;
  const size_t before = backlog_;
  if (last_frame_ != TimePoint{}) interval_ += (std::min<Nanoseconds>(now - last_frame_, 200ms) - interval_) / 8;
  last_frame_ = now;
  expire(now);
  if (frames_.size() == kFrames) frames_.pop_front();
  const bool plenty =
      feedback() && rate() > kPlenty * static_cast<double>(slices.bytes.size()) / to_seconds(interval_);
  StoredFrame& frame = frames_.emplace_back(slices, ++answers_, deadline, plenty);
  gate_.answered(frame.frame(), frame.bytes(), now);
  if (made_anew_ != frame.frame() && worth_parity(deadline, now)) frame.protect(std::min(0.4, loss()));
  for (uint16_t i = 0; i < frame.slice_count(); ++i) {
    push(fresh_, {answers_, frame.frame(), Cargo::slice, i, frame.body(i).size() + kSealBytes});
  }
  for (uint16_t i = 0; i < frame.parity_count(); ++i) {
    push(fresh_, {answers_, frame.frame(), Cargo::parity, i, frame.parity_body(i).size() + kSealBytes});
  }
  spread_rate_ = static_cast<double>(backlog_) / to_seconds(std::min(kLongestSpread, interval_ / 2));
  return backlog_ - before;
}

// Where a lost slice can come again in time, that costs less.
bool LinkSender::worth_parity(TimePoint deadline, TimePoint now) const {
  if (!parity() || loss() < kLeastLoss) return false;
  const Nanoseconds again = rtt() + rtt() / 8 + rtt() / 2 + 2 * std::chrono::milliseconds(10);
  const Nanoseconds time = deadline == TimePoint::max() ? 2 * interval_ : deadline - now;
  return again > time;
}

void LinkSender::push(std::deque<Item>& queue, const Item& item) {
  queue.push_back(item);
  backlog_ += item.bytes;
}

void LinkSender::pop(std::deque<Item>& queue) {
  backlog_ -= queue.front().bytes;
  queue.pop_front();
}

void LinkSender::pop_fresh(bool sent) {
  const Item item = fresh_.front();
  pop(fresh_);
  whole_ = whole_ && sent;
  if (!fresh_.empty() && fresh_.front().answer == item.answer) return;
  ends_.push_back({item.frame, whole_});
  whole_ = true;
}

std::optional<FrameEnd> LinkSender::take_end() {
  if (ends_.empty()) return std::nullopt;
  const FrameEnd end = ends_.front();
  ends_.pop_front();
  return end;
}

StoredFrame* LinkSender::find(uint64_t answer) {
  for (StoredFrame& stored : frames_) {
    if (stored.answer() == answer) return &stored;
  }
  return nullptr;
}

// Empty: it has lost its use.
std::optional<Outgoing> LinkSender::offer(const Item& item, TimePoint now) {
  const StoredFrame* frame = find(item.answer);
  if (!frame || now >= frame->useful_until()) {
    ++counters_.too_late;
    return std::nullopt;
  }
  offered_ = item;
  const bool parity = item.cargo == Cargo::parity;
  return Outgoing{kind_of(item.cargo), parity ? frame->parity_body(item.number) : frame->body(item.number)};
}

std::optional<Outgoing> LinkSender::next(TimePoint now) {
  offered_.reset();
  if (const auto tail = loss_detection_.take_tail(now)) handle_tail(*tail, now);
  if (feedback() && !pacer_.may_send(now)) {
    limited_ = limited_ || (backlog_ > 0 && rate() <= spread_rate_);
    return std::nullopt;
  }
  if (feedback()) {
    if (const auto size = mtu_.probe_due(now); size && rtt().count() > 0) {
      probe_.assign(*size - kSealBytes, 0);
      offered_ = {0, {}, Cargo::probe, 0, *size};
      return Outgoing{DatagramKind::probe, probe_};
    }
  }
  for (offered_again_ = true; !again_.empty(); pop(again_)) {
    if (auto out = offer(again_.front(), now)) return out;
  }
  for (offered_again_ = false; !fresh_.empty(); pop_fresh(false)) {
    if (auto out = offer(fresh_.front(), now)) return out;
  }
  return std::nullopt;
}

double LinkSender::pace() const { return std::min(rate(), std::max(spread_rate_, RateController::kLeastRate)); }

void LinkSender::sent(uint64_t sequence, size_t datagram_bytes, TimePoint now) {
  ++counters_.sent;
  if (!offered_) return;
  const Item item = *offered_;
  offered_.reset();
  if (item.cargo == Cargo::probe) {
    mtu_.probe_sent();
    extra_bytes_ += datagram_bytes;
  } else if (offered_again_) {
    pop(again_);
    ++counters_.retransmitted;
    extra_bytes_ += datagram_bytes;
  } else {
    if (StoredFrame* frame = find(item.answer)) frame->sent(now);
    counters_.parity += item.cargo == Cargo::parity;
    pop_fresh(true);
  }
  if (!feedback()) return;
  pacer_.sent(datagram_bytes, pace(), now);
  loss_detection_.sent(sequence,
                       {now, static_cast<uint32_t>(datagram_bytes), item.cargo, item.answer, item.number});
}

void LinkSender::hear(const protocol::Feedback& said, TimePoint now) {
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
  report.queue = queue_.now();
  report.delivered = delivered();
  report.arrived = static_cast<uint32_t>(update.arrived.size());
  for (const SentDatagram& datagram : update.lost) report.lost += datagram.cargo != Cargo::probe;
  report.newest_sent = newest_arrived_sent_;
  report.limited = std::exchange(limited_, false);
  rate_.observe(report, now);
}

void LinkSender::handle_arrivals(const std::vector<Arrival>& arrived, TimePoint now) {
  for (const Arrival& a : arrived) {
    ++counters_.arrived;
    newest_arrived_sent_ = std::max(newest_arrived_sent_, a.sent.at);
    queue_.add(a.one_way, now);
    deliveries_.push_back({a.sent.at.time_since_epoch() + a.one_way, a.sent.bytes});
    if (a.sent.cargo == Cargo::probe) {
      mtu_.probe_arrived(a.sent.bytes, now);
      continue;
    }
    mtu_.arrived(a.sent.bytes);
    StoredFrame* frame = find(a.sent.answer);
    if (frame && a.sent.cargo == Cargo::slice) frame->slice_arrived(a.sent.number);
  }
  while (!deliveries_.empty() && deliveries_.back().arrived - deliveries_.front().arrived > kDeliveredOver) {
    deliveries_.pop_front();
  }
}

double LinkSender::delivered() const {
  size_t bytes = 0;
  for (const Bytes& delivery : deliveries_) bytes += delivery.bytes;
  if (deliveries_.empty()) return 0;
  const Nanoseconds span = deliveries_.back().arrived - deliveries_.front().arrived;
  return static_cast<double>(bytes) / to_seconds(std::max<Nanoseconds>(span, 10ms));
}

void LinkSender::handle_losses(const std::vector<SentDatagram>& lost, TimePoint now) {
  for (const SentDatagram& datagram : lost) {
    if (datagram.cargo == Cargo::probe) {
      mtu_.probe_lost(now);
      continue;
    }
    ++counters_.lost;
    mtu_.lost(datagram.bytes, now);
    send_again(datagram, now);
  }
}

// It may have arrived for all we know: it counts as lost nowhere.
void LinkSender::handle_tail(const SentDatagram& tail, TimePoint now) {
  if (tail.cargo == Cargo::probe) return mtu_.probe_lost(now);
  send_again(tail, now);
}

void LinkSender::send_again(const SentDatagram& datagram, TimePoint now) {
  StoredFrame* frame = find(datagram.answer);
  if (!frame) return;
  if (datagram.cargo == Cargo::parity) return frame->parity_lost(datagram.number);
  const bool in_time = now + rtt() / 2 < frame->useful_until();
  if (frame->slice_lost(datagram.number) && in_time) {
    push(again_, {datagram.answer, frame->frame(), Cargo::slice, datagram.number, datagram.bytes});
  }
}

void LinkSender::expire(TimePoint now) {
  while (!frames_.empty() && frames_.front().useful_until() <= now) frames_.pop_front();
}

TimePoint LinkSender::wake_at(TimePoint now) const {
  if (!feedback()) return backlog_ > 0 ? now : TimePoint::max();
  // Not at once: a batch may gather.
  const TimePoint paced = backlog_ > 0 ? std::max(now + Pacer::kBatch, pacer_.next()) : TimePoint::max();
  return std::min(paced, loss_detection_.tail_due());
}

bool LinkSender::take_lost(FrameId frame, TimePoint now) {
  if (!feedback() || frames_.empty()) return false;
  const StoredFrame& newest = frames_.back();
  // Parity of one answer and slices of another would rebuild nonsense, if some came of which we have not heard.
  if (newest.frame() != frame || newest.parity_count() > 0) return false;
  if (newest.any_arrived() || now < newest.useful_until()) return false;
  frames_.pop_back();
  made_anew_ = frame;
  return true;
}

// The frame will be cut for datagrams as long as they may be now.
bool LinkSender::takes_view(TimePoint now) {
  if (feedback() && loss_detection_.silence(now) > 4 * rtt() + kSilence) mtu_.silent(now);
  if (!feedback() || gate_.open(backlog_, rate(), now)) return true;
  limited_ = true;
  return false;
}

TimePoint LinkSender::takes_view_at(TimePoint now) const {
  return feedback() ? gate_.opens_at(backlog_, rate(), now) : now;
}

}  // namespace gnomon::daemon
