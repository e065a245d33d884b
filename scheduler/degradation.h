// What a session is given less of when the device cannot keep up with it, and when it gets it back.
//
// A ladder of operating points: the rate goes down first, then the size, then lights, each as far as its tenant allows. One step
// down after two bad windows in a row, one up after a row of good ones. A step up that fails makes the next try wait
// twice as long, so that a steady overload settles instead of swinging. Pure: the caller counts and ticks.
#pragma once

#include <cstdint>

#include "common/clock.h"

namespace gnomon::scheduler {

// How far a tenant lets its sessions go down, as shares of what was granted; 1: not at all.
struct DegradationTerms {
  double least_rate = 0.5;
  double least_size = 1;    // of each side
  double least_lights = 1;  // that are traced
};

struct OperatingPoint {
  double rate = 1;  // shares of what was granted
  double size = 1;
  double lights = 1;
  friend bool operator==(const OperatingPoint&, const OperatingPoint&) = default;
};

// What happened to one session in one window.
struct Window {
  uint32_t offered = 0;   // views that came, as far as the rate in force allows them
  uint32_t answered = 0;  // of them, those that were rendered
};

class Degradation {
 public:
  explicit Degradation(const DegradationTerms& terms = {}) : terms_(terms) {}

  // Other limits from the next step on.
  void set_terms(const DegradationTerms& terms) { terms_ = terms; }

  // True: the operating point has changed.
  bool observe(const Window& window);

  OperatingPoint point() const;

 private:
  bool down();
  bool up();
  uint32_t deepest() const;

  DegradationTerms terms_;
  uint32_t level_ = 0;  // steps below what was granted
  uint32_t bad_ = 0, good_ = 0;
  uint32_t patience_ = 0;       // good windows before a step up, beyond the usual ones
  uint32_t since_step_up_ = 0;  // windows; 0: there was none
};

}  // namespace gnomon::scheduler
