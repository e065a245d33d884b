#include "tests/unit/link/simulated_session.h"

#include <algorithm>
#include <random>

#include "protocol/codec.h"

namespace gnomon::tests {
namespace {

using daemon::Outgoing;
using protocol::DatagramKind;

protocol::EncodedMask made_frame(const SessionPlan& plan, size_t body_bytes) {
  std::mt19937_64 random(42);
  std::vector<uint64_t> words(plan.grid.word_count());
  for (uint64_t& word : words) word = static_cast<double>(random() % 1000) < plan.busy * 1000 ? random() : 0;
  protocol::EncodedMask encoded;
  const auto done = protocol::FrameEncoder().encode(TileMaskView{plan.grid, words}, protocol::CodecId::tiles_lz4,
                                                    body_bytes - protocol::kSliceHeaderBytes, encoded);
  if (!done) std::abort();
  return encoded;
}

}  // namespace

SimulatedSession::SimulatedSession(EventQueue& events, netsim::Link& up, netsim::Link& down,
                                   const SessionPlan& plan)
    : events_(events),
      up_(up),
      down_(down),
      plan_(plan),
      link_(plan.features),
      body_bytes_(link_.slice_body_bytes()),
      assembler_(plan.grid),
      newest_(plan.grid.word_count()) {
  slices_ = made_frame(plan, body_bytes_);
  events_.at(plan.start, [this] { ask(); });
}

void SimulatedSession::ask() {
  const FrameId frame{static_cast<uint32_t>(++asked_)};
  const auto fate = up_.send_datagram(140, events_.now());
  if (fate.copies > 0) {
    events_.at(fate.at[0], [this, frame] {
      if (waiting_ && *waiting_ > frame) return;
      waiting_ = frame;
      waiting_deadline_ = plan_.deadline.count() > 0 ? events_.now() + plan_.deadline : TimePoint::max();
      answer();
    });
  }
  events_.at(events_.now() + Nanoseconds(static_cast<int64_t>(1e9 / plan_.rate_hz)), [this] { ask(); });
}

void SimulatedSession::answer() {
  const TimePoint now = events_.now();
  if (!waiting_) return;
  if (!link_.may_request(now)) return wake(link_.may_request_at(now));
  const FrameId frame = *waiting_;
  waiting_.reset();
  link_.on_request(frame, now);
  events_.at(now + plan_.render, [this, frame, deadline = waiting_deadline_] { rendered(frame, deadline); });
}

void SimulatedSession::rendered(FrameId frame, TimePoint deadline) {
  if (plan_.longer_slices && std::exchange(body_bytes_, link_.slice_body_bytes()) != link_.slice_body_bytes()) {
    slices_ = made_frame(plan_, body_bytes_);
  }
  for (auto& header : slices_.slices) header.frame = frame;
  link_.add(slices_, deadline, events_.now());
  through_[frame] = events_.now();
  pump();
}

void SimulatedSession::pump() {
  const TimePoint now = events_.now();
  while (const auto out = link_.next(now)) carry(*out);
  answer();
  wake(link_.wake_at(now));
}

void SimulatedSession::wake(TimePoint when) {
  when = std::max(when, events_.now() + std::chrono::microseconds(50));
  if (when >= next_wake_ || when == TimePoint::max()) return;
  next_wake_ = when;
  events_.at(when, [this, when] {
    if (next_wake_ != when) return;
    next_wake_ = TimePoint::max();
    pump();
  });
}

void SimulatedSession::carry(const Outgoing& out) {
  const TimePoint now = events_.now();
  const size_t size = out.body.size() + protocol::kHeaderBytes + protocol::kTagBytes;
  if (omitted_.omit_next()) link_.omitted(++sequence_);
  const uint64_t sequence = ++sequence_;
  const auto fate = down_.send_datagram(size, now);
  if (fate.kind == netsim::Fate::Kind::arrives || fate.kind == netsim::Fate::Kind::lost)
    waits_.push_back(fate.queued);
  for (const TimePoint at : fate.arrivals()) {
    events_.at(at, [this, sequence, kind = out.kind, body = Bytes(out.body.begin(), out.body.end()), size] {
      delivered_ += size;
      receive(sequence, kind, body);
    });
  }
  if (out.kind == DatagramKind::frame_slice) {
    const auto slice = protocol::decode_frame_slice(out.body);
    // When the first transmission of a frame's last slice has arrived, the frame before is examined.
    if (slice && slice->header.slice + 1u == slice->header.slice_count && through_.contains(slice->header.frame)) {
      const FrameId frame = slice->header.frame;
      const auto found = through_.find(frame);
      if (found != through_.begin()) {
        const FrameId before = std::prev(found)->first;
        events_.at(now + fate.queued + plan_.path_delay + std::chrono::milliseconds(1),
                   [this, before] { look(before); });
        through_.erase(through_.begin(), found);
      }
    }
  }
  link_.sent(sequence, size, now);
}

void SimulatedSession::receive(uint64_t sequence, DatagramKind kind, const Bytes& body) {
  const TimePoint now = events_.now();
  arrivals_.received(sequence, now);
  if (arrivals_.due_at() < next_report_) {
    next_report_ = std::max(arrivals_.due_at(), now);
    events_.at(next_report_, [this] { report(); });
  }
  if (kind == DatagramKind::frame_slice) add_slice(body);
  if (kind != DatagramKind::frame_parity) return;
  const auto parity = protocol::decode_parity(body);
  if (!parity) return;
  for (const Bytes& rebuilt : recovery_.add_parity(*parity)) {
    ++recovered_;
    add_slice(rebuilt);
  }
}

void SimulatedSession::add_slice(const Bytes& body) {
  const auto slice = protocol::decode_frame_slice(body);
  if (!slice) return;
  complete_ += assembler_.add(*slice) == client::SliceOutcome::completed;
  while (auto frame = assembler_.take_finished()) assembler_.recycle(std::move(*frame));
  const protocol::SliceHeader& header = slice->header;
  for (size_t light = header.first_light; light < size_t{header.first_light} + header.light_count; ++light) {
    const auto first = newest_.begin() + static_cast<long>(light * plan_.grid.tile_count() + header.first_tile);
    for (auto word = first; word != first + header.tile_count; ++word) *word = std::max(*word, header.frame);
  }
  for (const Bytes& rebuilt : recovery_.add_slice(header, body)) {
    ++recovered_;
    add_slice(rebuilt);
  }
}

void SimulatedSession::report() {
  const TimePoint now = events_.now();
  next_report_ = TimePoint::max();
  if (arrivals_.due_at() > now) return;
  protocol::Feedback feedback = arrivals_.take(now);
  feedback.recovered = static_cast<uint32_t>(recovered_);
  const auto fate = up_.send_datagram(62 + 2u * feedback.count, now);
  if (fate.copies == 0) return;
  events_.at(fate.at[0], [this, feedback] {
    // An honest client's report is taken, in any scenario.
    if (link_.on_feedback(feedback, events_.now()) != daemon::FeedbackVerdict::taken) std::abort();
    pump();
  });
}

void SimulatedSession::look(FrameId frame) {
  const auto fresh = std::count_if(newest_.begin(), newest_.end(), [&](FrameId word) { return word >= frame; });
  looks_.push_back({events_.now(), frame, static_cast<double>(fresh) / static_cast<double>(newest_.size())});
}

double SimulatedSession::fresh_share(TimePoint from, TimePoint to) const {
  double sum = 0, count = 0;
  for (const Look& look : looks_) {
    if (look.at < from || look.at >= to) continue;
    sum += look.fresh;
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

Nanoseconds SimulatedSession::longest_gap(TimePoint from, TimePoint to) const {
  Nanoseconds longest{};
  TimePoint last = from;
  for (const Look& look : looks_) {
    if (look.at < from || look.at >= to) continue;
    longest = std::max(longest, look.at - last);
    last = look.at;
  }
  return std::max(longest, to - last);
}

Nanoseconds SimulatedSession::wait_percentile(double share) const {
  if (waits_.empty()) return {};
  auto sorted = waits_;
  std::sort(sorted.begin(), sorted.end());
  return sorted[static_cast<size_t>(share * static_cast<double>(sorted.size() - 1))];
}

}  // namespace gnomon::tests
