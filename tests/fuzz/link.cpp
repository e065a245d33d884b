// A session's link under a client that says anything: frames, time, sending and Feedbacks are steps decoded from the
// input. Whatever it says, the link keeps to its bounds, believes no invention and overflows nowhere.
#include <set>

#include "daemon/link/link_sender.h"
#include "tests/fuzz/target.h"
#include "tests/unit/link/made_frame.h"

namespace gnomon::fuzz {
namespace {

using namespace std::chrono_literals;
using daemon::FeedbackVerdict;
using daemon::LinkSender;
using daemon::RateController;

constexpr size_t kMostSteps = 400;
constexpr size_t kSealBytes = protocol::kHeaderBytes + protocol::kTagBytes;

class Steps {
 public:
  explicit Steps(std::span<const uint8_t> input)
      : input_(input), features_(protocol::kFeatureFeedback | take_number(input_, 1) * protocol::kFeatureParity) {}

  void run() {
    for (size_t i = 0; i < kMostSteps && !input_.empty(); ++i) {
      step();
      check();
    }
  }

 private:
  void step() {
    switch (take_number(input_, 8)) {
      case 0: now_ += std::chrono::microseconds(take_number(input_, 65535)); break;
      case 1: now_ += std::chrono::milliseconds(take_number(input_, 65535)); break;
      case 2: add(); break;
      case 3: omit(); break;
      case 4: pong(); break;
      case 5: link_.take_lost(FrameId{frame_}, now_); break;
      case 6: report(); break;
      case 7: link_.begin_path(now_); break;
      default: report(); break;
    }
    send();
  }

  void add() {
    const auto slices = static_cast<uint16_t>(1 + take_number(input_, 99));
    const TimePoint deadline = take_number(input_, 1) ? now_ + 100ms : TimePoint::max();
    if (link_.may_request(now_)) link_.on_request(FrameId{++frame_}, now_);
    link_.add(daemon::frame_of(frame_, slices, 1 + take_number(input_, 1099)), deadline, now_);
  }

  void omit() {
    omitted_.insert(++sequence_);
    link_.omitted(sequence_);
  }

  void pong() { link_.sent(++sequence_, protocol::kMaxDatagramBytes, now_); }

  void send() {
    for (int i = 0; i < 64; ++i) {
      const auto out = link_.next(now_);
      if (!out) return;
      require(out->body.size() + kSealBytes <= protocol::kMaxProbedBytes, "no datagram is longer than any may be");
      link_.sent(++sequence_, out->body.size() + kSealBytes, now_);
    }
  }

  // Numbers near what was sent, near the ends of their range, or any; a clock that does what it likes.
  uint64_t take_wide() {
    uint64_t bytes = 0;
    const uint32_t where = take_number(input_, 4);
    for (const uint8_t byte : take(input_, where == 0 ? 8 : 2)) bytes = bytes << 8 | byte;
    switch (where) {
      case 0: return bytes;
      case 1: return bytes % 1024;
      case 2: return ~uint64_t{0} - bytes;
      case 3: return (uint64_t{1} << 63) + bytes - 32768;
      default: return sequence_ + 512 - bytes % 1024;
    }
  }

  void report() {
    protocol::Feedback said;
    said.first = take_wide();
    said.time_us = take_wide();
    said.recovered = take_number(input_, 65535);
    said.incomplete = take_number(input_, 65535);
    said.count = static_cast<uint16_t>(take_number(input_, protocol::kMaxReported));
    const uint32_t pattern = take_number(input_, 65535);
    for (size_t i = 0; i < said.count; ++i) said.ages[i] = static_cast<uint16_t>(pattern * i % 7 ? pattern : 0);
    const uint64_t arrived = link_.counters().arrived;
    const bool honest = is_possible(said);
    const FeedbackVerdict verdict = link_.on_feedback(said, now_);
    if (verdict == FeedbackVerdict::taken)
      return require(honest || forgotten(said), "what was never sent did not arrive");
    require(link_.counters().arrived == arrived, "what is not taken has no effect");
    if (verdict == FeedbackVerdict::invented) require(!honest, "what was sent may have arrived");
  }

  bool is_possible(const protocol::Feedback& said) const {
    for (uint64_t i = 0; i < said.count; ++i) {
      const uint64_t sequence = said.first + i;
      if (said.ages[i] != 0 && (sequence == 0 || sequence > sequence_ || omitted_.contains(sequence))) return false;
    }
    return true;
  }

  // Numbers that were left out long ago are not remembered.
  bool forgotten(const protocol::Feedback& said) const {
    return said.first + protocol::kMaxReported < sequence_ && said.first != 0;
  }

  void check() {
    require(link_.rate() >= RateController::kLeastRate && link_.rate() <= RateController::kMostRate,
            "the rate's bounds");
    require(link_.rtt() >= 0ns && link_.rtt() <= 10s, "the round trip's bounds");
    require(link_.queue_delay() >= -3h && link_.queue_delay() <= 3h, "the queue's bounds");
    require(link_.slice_body_bytes() + kSealBytes <= protocol::kMaxProbedBytes, "a slice fits a datagram");
    require(link_.wake_at(now_) >= now_ - 24h, "there is a next time");
    require(link_.may_request_at(now_) >= now_, "and one for the next view");
    while (link_.take_end()) {
    }
    (void)link_.take_extra_bytes();
  }

  std::span<const uint8_t> input_;
  uint64_t features_;
  LinkSender link_{features_};
  TimePoint now_{1000s};
  uint64_t sequence_ = 0;
  uint32_t frame_ = 0;
  std::set<uint64_t> omitted_;
};

}  // namespace
}  // namespace gnomon::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  gnomon::fuzz::Steps(std::span(data, size)).run();
  return 0;
}
