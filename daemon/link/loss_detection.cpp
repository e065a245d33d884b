#include "daemon/link/loss_detection.h"

#include <algorithm>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr Nanoseconds kFirstRtt = 100ms;         // assumed until a round trip has been measured
constexpr Nanoseconds kFeedbackInterval = 15ms;  // of a client's Feedback, with some lateness
constexpr Nanoseconds kLeastReordering = 2ms;
constexpr Nanoseconds kReordering = 15ms;  // paths reorder datagrams by as much
constexpr Nanoseconds kGivenUp = 2s;       // an older datagram is lost in any case

constexpr Nanoseconds kLongestRtt = 10s;  // a longer one is a client's invention

std::chrono::microseconds waited(uint16_t age) {
  return std::chrono::microseconds(uint32_t{protocol::kAgeUnitUs} * (age - 1u));
}

}  // namespace

void LossDetection::sent(uint64_t sequence, const SentDatagram& datagram) {
  append(sequence, {datagram, State::flying, ++tracked_});
  last_sent_ = datagram.at;
  if (unheard_++ == 0) silent_since_ = datagram.at;
}

void LossDetection::sent_beside(uint64_t sequence) { append(sequence, {.state = State::beside}); }

void LossDetection::omitted(uint64_t sequence) { append(sequence, {.state = State::omitted}); }

void LossDetection::append(uint64_t sequence, const Entry& entry) {
  if (sequence < end() || sequence - end() >= kMaxEntries) {
    entries_.clear();
    first_ = unsettled_ = sequence;
  }
  while (end() < sequence) entries_.push_back({.state = State::beside});
  entries_.push_back(entry);
  while (entries_.size() > kMaxEntries) {
    entries_.pop_front();
    ++first_;
  }
  unsettled_ = std::max(unsettled_, first_);
  settle();
}

void LossDetection::begin_path(TimePoint now) {
  path_began_ = now;
  smoothed_ = variance_ = {};
  tails_ = 0;
}

bool LossDetection::is_invented(const protocol::Feedback& feedback) const {
  for (uint64_t i = 0; i < feedback.count; ++i) {
    const uint64_t sequence = feedback.first + i;
    if (feedback.ages[i] == 0) continue;
    if (sequence == 0 || sequence >= end()) return true;
    if (remembers(sequence) && entries_[static_cast<size_t>(sequence - first_)].state == State::omitted)
      return true;
  }
  return false;
}

PathUpdate LossDetection::take(const protocol::Feedback& feedback, TimePoint now) {
  PathUpdate update;
  const TimePoint said_at = clock_.read(feedback.time_us, now);
  const uint64_t count = std::min<uint64_t>(feedback.count, ~feedback.first);  // sequence numbers must not wrap
  for (uint64_t i = 0; i < count; ++i) {
    const uint16_t age = feedback.ages[i];
    Entry* entry = age == 0 ? nullptr : find(feedback.first + i);
    if (!entry || (entry->state != State::flying && entry->state != State::lost)) continue;
    entry->state = State::arrived;
    const SentDatagram& datagram = entry->datagram;
    update.arrived.push_back({datagram, said_at - waited(age) - datagram.at});
    if (feedback.first + i < newest_) continue;
    newest_ = feedback.first + i;
    newest_ordinal_ = entry->ordinal;
    newest_sent_ = datagram.at;
    if (age == protocol::kOldest || datagram.at < path_began_) continue;
    update.rtt = std::clamp<Nanoseconds>(now - datagram.at - waited(age), 1us, kLongestRtt);
  }
  if (!update.arrived.empty()) {
    tails_ = 0;
    unheard_ = tracked_ - newest_ordinal_;
    silent_since_ = now;
  }
  if (update.rtt.count() > 0) measure(update.rtt);
  find_losses(now, update.lost);
  settle();
  return update;
}

LossDetection::Entry* LossDetection::find(uint64_t sequence) {
  return remembers(sequence) ? &entries_[static_cast<size_t>(sequence - first_)] : nullptr;
}

bool LossDetection::is_lost(const Entry& entry, TimePoint now) const {
  const Nanoseconds rtt = rtt_or_guess(), age = now - entry.datagram.at;
  if (age >= kGivenUp) return true;
  const bool overtaken =
      entry.ordinal + kLaterOnes <= newest_ordinal_ ||
      (entry.ordinal < newest_ordinal_ && newest_sent_ - entry.datagram.at >= std::max(rtt / 4, kReordering));
  return overtaken && age >= rtt + std::max(rtt / 8, kLeastReordering);
}

void LossDetection::find_losses(TimePoint now, std::vector<SentDatagram>& lost) {
  for (uint64_t s = std::max(unsettled_, first_); s < newest_; ++s) {
    Entry* entry = find(s);
    if (!entry || entry->state != State::flying || !is_lost(*entry, now)) continue;
    entry->state = State::lost;
    lost.push_back(entry->datagram);
  }
}

std::optional<SentDatagram> LossDetection::take_tail(TimePoint now) {
  if (now < tail_due()) return std::nullopt;
  last_tail_ = now;
  ++tails_;
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    if (entry->state != State::flying) continue;
    entry->state = State::lost;
    const SentDatagram tail = entry->datagram;
    settle();
    return tail;
  }
  return std::nullopt;
}

// The timeout counts from the newest datagram: while datagrams follow, their arrival reveals a loss.
TimePoint LossDetection::tail_due() const {
  if (unsettled_ >= end()) return TimePoint::max();
  return std::max(last_sent_, last_tail_) + tail_patience();
}

Nanoseconds LossDetection::silence(TimePoint now) const {
  return unheard_ < kLaterOnes ? Nanoseconds{} : now - silent_since_;
}

Nanoseconds LossDetection::rtt_or_guess() const { return smoothed_.count() > 0 ? smoothed_ : kFirstRtt; }

Nanoseconds LossDetection::tail_patience() const {
  // The timeout doubles with each probe (RFC 9002, 6.2.1), so that a busy client is not flooded with probes.
  return (rtt_or_guess() + std::max(4 * variance_, rtt_or_guess() / 8) + kFeedbackInterval) *
         (1 << std::min(tails_, 6u));
}

// Smoothed round-trip time and its variance (RFC 6298, 2).
void LossDetection::measure(Nanoseconds rtt) {
  if (smoothed_.count() == 0) {
    smoothed_ = rtt;
    variance_ = rtt / 2;
    return;
  }
  const Nanoseconds off = rtt > smoothed_ ? rtt - smoothed_ : smoothed_ - rtt;
  variance_ = (3 * variance_ + off) / 4;
  smoothed_ = (7 * smoothed_ + rtt) / 8;
}

// Settled entries are kept for a while, as a datagram that was declared lost may still arrive.
void LossDetection::settle() {
  while (unsettled_ < end() && find(unsettled_)->state != State::flying) ++unsettled_;
  while (entries_.size() > 2 * protocol::kMaxReported && first_ < unsettled_) {
    entries_.pop_front();
    ++first_;
  }
}

}  // namespace gnomon::daemon
