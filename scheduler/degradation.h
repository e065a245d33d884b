// Reduces what a session is served while the device cannot keep up with it, and restores it afterwards.
//
// The operating points form a ladder: the rate goes down first, then the samples (the points of area lights, a quarter at
// a time, then the occlusion of ambient light, from all pixels to a quarter of them and to none), then the size, then
// the number of lights, each as far as the tenant allows. Two bad windows in a row lead one step down, a run of good
// windows one step up. Each step up that fails doubles the additional good windows that the next attempt needs, so that
// a steady overload settles instead of oscillating. The class reads no clock: the caller counts views and calls
// observe() at the end of each window.
#pragma once

#include <cstdint>

#include "common/clock.h"
#include "common/sample_counts.h"

namespace gnomon::scheduler {

// The least that a tenant's sessions may be served, as shares of what was granted; 1: no degradation.
struct DegradationLimits {
  double least_rate = 0.5;
  double least_size = 1;       // of each side
  double least_lights = 1;     // of the lights that are traced
  uint32_t least_samples = 1;  // of each area light; no share: 1, 4 or 16
};

struct OperatingPoint {
  double rate = 1;  // shares of what was granted
  double size = 1;
  double lights = 1;
  uint32_t fewer_samples = 0;  // steps from 16 to 4 and from 4 to 1, then from full to half and to no occlusion
  friend bool operator==(const OperatingPoint&, const OperatingPoint&) = default;
};

// The views of one session in one window of time.
struct ServiceWindow {
  uint32_t offered = 0;   // views that arrived, as far as the rate in force admits them
  uint32_t answered = 0;  // those of them that were rendered
};

class Degradation {
 public:
  explicit Degradation(const DegradationLimits& limits = {}) : limits_(limits) {}

  // Replaces the limits. point() follows them at once; observe() does not report that change. `samples`: granted.
  void set_limits(const DegradationLimits& limits, SampleCounts samples = {});

  // Returns true if the operating point has changed.
  bool observe(const ServiceWindow& window);

  OperatingPoint point() const;
  SampleCounts samples() const;  // in force at point()

 private:
  bool down();
  bool up();
  uint32_t sample_steps() const;
  uint32_t deepest() const;

  DegradationLimits limits_;
  SampleCounts samples_;         // granted
  uint32_t level_ = 0;           // steps below what was granted
  uint32_t bad_ = 0, good_ = 0;  // windows in a row
  uint32_t patience_ = 0;        // good windows that a step up needs beyond the usual ones
  uint32_t since_step_up_ = 0;   // windows since the last step up; 0: it has held, or a step down followed it
};

}  // namespace gnomon::scheduler
