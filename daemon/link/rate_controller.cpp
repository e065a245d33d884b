#include "daemon/link/rate_controller.h"

#include <algorithm>
#include <cmath>

namespace gnomon::daemon {
namespace {

using namespace std::chrono_literals;

constexpr double kDatagram = 1200;       // bytes; TCP's segment size
constexpr Nanoseconds kLeastRtt = 10ms;  // reports are not more frequent
constexpr double kStartGrowth = 1.25;    // factor for each round trip
// In the start phase a queue grows fast, and for another round trip after it is seen: the first sign of one ends it.
constexpr Nanoseconds kFirstSign = RateController::kTarget / 4;
constexpr double kMildFall = 0.85;  // smallest cut: factor of what the path delivers
constexpr double kDeepFall = 0.3;   // deepest cut: factor of what the path delivers
constexpr double kHarder = 0.1;     // growth increases by this for each round trip without a queue
constexpr uint32_t kVainFalls = 3;  // after as many without effect, another flow must be filling the queue
constexpr Nanoseconds kCompeteFor = 5s;
constexpr double kTcpFall = 0.7;           // CUBIC's multiplicative decrease (RFC 9438, 4.6)
constexpr double kLossAveragedOver = 100;  // datagrams
constexpr double kHighLoss = 0.1;          // share of datagrams
constexpr uint32_t kMostShed = 3;          // falls for losses; then the losses count as the path's own
constexpr Nanoseconds kIgnoreLosses = 5s;

}  // namespace

void RateController::observe(const PathReport& report, TimePoint now) {
  count_losses(report);
  const Nanoseconds rtt = std::max(report.rtt, kLeastRtt);
  const Nanoseconds step = last_ == TimePoint{} ? kLeastRtt : std::min(now - last_, rtt);
  last_ = now;
  if (competing(now)) return compete(report, now, step);
  if (draining_ && report.queue < kTarget / 2) {
    draining_ = false;
    in_vain_ = 0;
    set(std::max(rate_, kMildFall * delivered_));
    hold_until_ = now + rtt;
  }
  if (now < hold_until_ || report.newest_sent < fell_) return;
  if (report.queue > (starting_ ? kFirstSign : kTarget)) return fall(report, now);
  if (loss_ > kHighLoss && shed_load(now, rtt)) return;
  if (loss_ < kHighLoss / 2) shed_ = 0;
  if (report.limited && !draining_ && report.queue <= (starting_ ? kFirstSign : kTarget) / 2) grow(report, step);
}

void RateController::count_losses(const PathReport& report) {
  const double count = report.arrived + report.lost;
  if (count == 0) return;
  const double weight = 1 - std::exp(-count / kLossAveragedOver);
  loss_ += weight * (report.lost / count - loss_);
}

void RateController::grow(const PathReport& report, Nanoseconds step) {
  const double rtt = to_seconds(std::max(report.rtt, kLeastRtt));
  const double rtts = to_seconds(step) / rtt;
  if (starting_) return set(rate_ * std::pow(kStartGrowth, rtts));
  clear_rtts_ += rtts;
  set(rate_ + rtts * (1 + kHarder * clear_rtts_) * kDatagram / rtt);
}

// The rate falls the deeper the longer the queue is, so that the queue drains within about four round trips.
void RateController::fall(const PathReport& report, TimePoint now) {
  const Nanoseconds rtt = std::max(report.rtt, kLeastRtt);
  if (!draining_) {
    rate_then_ = rate_;
    in_vain_ = 0;
    delivered_ = report.limited ? std::min(rate_, report.delivered) : rate_;
  } else if (report.queue < queue_then_ * 7 / 8) {
    in_vain_ = 0;
  } else if (++in_vain_ >= kVainFalls) {
    competing_until_ = now + kCompeteFor;
    draining_ = false;
    clear_rtts_ = 0;
    set(rate_then_);
    return;
  }
  queue_then_ = report.queue;
  fell_ = now;
  starting_ = false;
  draining_ = true;
  clear_rtts_ = 0;
  const Nanoseconds empty = std::max(report.rtt - report.queue, kLeastRtt);
  const double excess = to_seconds(report.queue - kTarget / 2) / (4 * to_seconds(empty));
  const double base = in_vain_ == 0 ? delivered_ : std::min(rate_, delivered_);
  set(base * std::clamp(1 - excess, kDeepFall, kMildFall));
  hold_until_ = now + rtt + kLeastRtt;
}

// Returns true if the rate fell. If several falls have not reduced the losses, they are not due to congestion: the rate
// is restored and losses are ignored for a while.
bool RateController::shed_load(TimePoint now, Nanoseconds rtt) {
  if (now < ignore_losses_until_) return false;
  starting_ = false;
  if (shed_ == 0) {
    rate_then_ = rate_;
    loss_then_ = loss_;
  }
  if (shed_ == kMostShed) {
    shed_ = 0;
    if (loss_ > 0.6 * loss_then_) {
      set(rate_then_);
      ignore_losses_until_ = now + kIgnoreLosses;
      return false;
    }
  }
  ++shed_;
  set(rate_ * kMildFall);
  hold_until_ = now + 2 * rtt;
  return true;
}

void RateController::compete(const PathReport& report, TimePoint now, Nanoseconds step) {
  const Nanoseconds rtt = std::max(report.rtt, kLeastRtt);
  if (report.lost > 0 && now >= hold_until_) {
    set(rate_ * kTcpFall);
    hold_until_ = now + rtt;
  } else if (report.limited) {
    set(rate_ + to_seconds(step) / to_seconds(rtt) * kDatagram / to_seconds(rtt));
  }
}

void RateController::set(double rate) { rate_ = std::clamp(rate, kLeastRate, kMostRate); }

}  // namespace gnomon::daemon
