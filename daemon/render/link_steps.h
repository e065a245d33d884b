// How a session is degraded when its link cannot carry its frames: first the codec gets denser, then the frames
// smaller, as far as the tenant allows. Before that the frame rate has fallen (daemon/link/request_gate.h), down to the
// tenant's least rate. Pure.
#pragma once

#include <cmath>
#include <cstdint>

#include "daemon/link/link_window.h"
#include "scheduler/degradation.h"

namespace gnomon::daemon {

class LinkSteps {
 public:
  // The limits hold from the next step on.
  void set_limits(const scheduler::DegradationLimits& tenant, bool has_denser_codec) {
    least_rate_ = tenant.least_rate;
    // A link is degraded by a denser codec first and by size after that, never by rate. The ladder knows rate and size
    // alone: its first step, a lower rate, is taken for the denser codec here, where there is one.
    ladder_.set_limits({.least_rate = has_denser_codec ? kOneStep : 1, .least_size = tenant.least_size});
  }

  // Returns true if a step was taken, up or down.
  bool observe(const LinkWindow& window) {
    const auto wanted = static_cast<uint32_t>(std::floor(window.offered * least_rate_));
    return ladder_.observe({wanted, std::min(window.taken, wanted)});
  }

  bool dense() const { return ladder_.point().rate < 1; }
  double size() const { return ladder_.point().size; }

 private:
  static constexpr double kOneStep = 0.7;

  double least_rate_ = 0.5;
  scheduler::Degradation ladder_;
};

}  // namespace gnomon::daemon
