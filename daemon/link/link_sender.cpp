#include "daemon/link/link_sender.h"

#include <algorithm>

#include "daemon/link/parity_plan.h"

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;
using protocol::DatagramKind;

constexpr Nanoseconds kLongestSpread = 4ms;  // of a frame's datagrams, where the rate allows more
constexpr Nanoseconds kDeliveredOver = 100ms;
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

LinkSender::LinkSender(uint64_t features) : features_(features) {}

size_t LinkSender::slice_body_bytes() const {
  return datagram_bytes() - kSealBytes - (parity() ? protocol::kParityOverhead : 0);
}

void LinkSender::add(const protocol::EncodedFrame& slices, TimePoint deadline, TimePoint now) {
  if (slices.slices.empty()) return;
  if (last_frame_ != TimePoint{}) interval_ += (std::min<Nanoseconds>(now - last_frame_, 200ms) - interval_) / 8;
  last_frame_ = now;
  expire(now);
  if (frames_.size() == kFrames) frames_.pop_front();
  StoredFrame& frame = frames_.emplace_back(slices, deadline);
  gate_.answered(frame.frame(), frame.bytes(), now);
  if (worth_parity(deadline, now)) frame.protect(std::min(0.4, loss()));
  for (uint16_t i = 0; i < frame.slice_count(); ++i) {
    push(fresh_, {frame.frame(), Cargo::slice, i, frame.body(i).size() + kSealBytes});
  }
  for (uint16_t i = 0; i < frame.parity_count(); ++i) {
    push(fresh_, {frame.frame(), Cargo::parity, i, frame.parity_body(i).size() + kSealBytes});
  }
  spread_rate_ = static_cast<double>(backlog_) / to_seconds(std::min(kLongestSpread, interval_ / 2));
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

StoredFrame* LinkSender::find(FrameId frame) {
  for (StoredFrame& stored : frames_) {
    if (stored.frame() == frame) return &stored;
  }
  return nullptr;
}

// What has lost its use is thrown away on the way.
std::optional<Outgoing> LinkSender::first_of(std::deque<Item>& queue, TimePoint now) {
  while (!queue.empty()) {
    const Item& item = queue.front();
    const StoredFrame* frame = find(item.frame);
    if (frame && now < frame->useful_until()) {
      offered_ = item;
      return Outgoing{kind_of(item.cargo),
                      item.cargo == Cargo::parity ? frame->parity_body(item.number) : frame->body(item.number)};
    }
    ++counters_.too_late;
    pop(queue);
  }
  return std::nullopt;
}

std::optional<Outgoing> LinkSender::next(TimePoint now) {
  offered_.reset();
  if (const auto tail = log_.take_tail(now)) handle_losses({*tail}, now);
  if (feedback() && !pacer_.may_send(now)) {
    limited_ = limited_ || (backlog_ > 0 && rate() <= spread_rate_);
    return std::nullopt;
  }
  if (feedback()) {
    if (const auto size = mtu_.probe_due(now); size && rtt().count() > 0) {
      probe_.assign(*size - kSealBytes, 0);
      offered_ = {{}, Cargo::probe, 0, *size};
      return Outgoing{DatagramKind::probe, probe_};
    }
  }
  if (auto again = first_of(again_, now)) return again;
  return first_of(fresh_, now);
}

double LinkSender::pace() const { return std::min(rate(), std::max(spread_rate_, RateController::kLeastRate)); }

void LinkSender::sent(uint64_t sequence, size_t datagram_bytes, TimePoint now) {
  ++counters_.sent;
  if (!offered_) return;
  const Item item = *offered_;
  offered_.reset();
  if (item.cargo == Cargo::probe) {
    mtu_.probe_sent();
  } else {
    const bool again = !again_.empty() && again_.front().frame == item.frame &&
                       again_.front().cargo == item.cargo && again_.front().number == item.number;
    pop(again ? again_ : fresh_);
    counters_.retransmitted += again;
    StoredFrame* frame = find(item.frame);
    if (frame && !again) frame->sent(now);
    counters_.parity += item.cargo == Cargo::parity;
  }
  if (!feedback()) return;
  pacer_.sent(datagram_bytes, pace(), now);
  log_.sent(sequence, {now, static_cast<uint32_t>(datagram_bytes), item.cargo, item.frame, item.number});
}

void LinkSender::hear(const protocol::Feedback& said, TimePoint now) {
  counters_.recovered += static_cast<uint32_t>(said.recovered - static_cast<uint32_t>(counters_.recovered));
  counters_.incomplete += static_cast<uint32_t>(said.incomplete - static_cast<uint32_t>(counters_.incomplete));
  const PathNews news = log_.take(said, now);
  handle_arrivals(news.arrived, now);
  handle_losses(news.lost, now);
  PathReport report;
  report.rtt = log_.rtt();
  report.queue = queue_.now();
  report.delivered = delivered();
  report.arrived = static_cast<uint32_t>(news.arrived.size());
  for (const SentDatagram& datagram : news.lost) report.lost += datagram.cargo != Cargo::probe;
  report.limited = std::exchange(limited_, false);
  rate_.observe(report, now);
}

void LinkSender::handle_arrivals(const std::vector<Arrival>& arrived, TimePoint now) {
  for (const Arrival& a : arrived) {
    ++counters_.arrived;
    queue_.add(a.one_way, now);
    deliveries_.push_back({a.sent.at.time_since_epoch() + a.one_way, a.sent.bytes});
    if (a.sent.cargo == Cargo::probe) {
      mtu_.probe_arrived(a.sent.bytes, now);
      continue;
    }
    mtu_.arrived(a.sent.bytes);
    StoredFrame* frame = find(a.sent.frame);
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

// Goes again what can still arrive in time.
void LinkSender::handle_losses(const std::vector<SentDatagram>& lost, TimePoint now) {
  for (const SentDatagram& datagram : lost) {
    if (datagram.cargo == Cargo::probe) {
      mtu_.probe_lost(now);
      continue;
    }
    ++counters_.lost;
    mtu_.lost(datagram.bytes, now);
    StoredFrame* frame = find(datagram.frame);
    if (!frame) continue;
    if (datagram.cargo == Cargo::parity) {
      frame->parity_lost(datagram.number);
      continue;
    }
    const bool in_time = now + rtt() / 2 < frame->useful_until();
    if (frame->slice_lost(datagram.number) && in_time) {
      push(again_, {datagram.frame, Cargo::slice, datagram.number, datagram.bytes});
    }
  }
}

void LinkSender::expire(TimePoint now) {
  while (!frames_.empty() && frames_.front().useful_until() <= now) frames_.pop_front();
}

TimePoint LinkSender::wake_at(TimePoint now) const {
  if (!feedback()) return backlog_ > 0 ? now : TimePoint::max();
  const TimePoint paced = backlog_ > 0 ? std::max(now, pacer_.next()) : TimePoint::max();
  return std::min(paced, log_.tail_due());
}

bool LinkSender::takes_view(TimePoint now) {
  if (!feedback() || gate_.open(backlog_, rate(), now)) return true;
  limited_ = true;
  return false;
}

TimePoint LinkSender::takes_view_at(TimePoint now) const {
  return feedback() ? gate_.opens_at(backlog_, rate(), now) : now;
}

}  // namespace gnomon::daemon
