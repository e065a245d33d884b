// The dissertation's automatic switching (3.5): a value is made of how much the camera's position, up and target
// changed and of the latency, each with a weight; three thresholds decide.
//
//   by default not sequential: shows the newest camera, predicted
//   above `high`: sequential for `dwell` frames: shows only what has masks (in this framework: x = 0)
//   then, every frame: above `mid` for `dwell` frames more; between `low` and `mid` still; below `low` back at once
//
// Latency speaks for not being sequential, so its weight counts against the rest. The dissertation names no figures;
// these are what did best here (tests/eval).
#pragma once

#include "client/prediction/ahead.h"

namespace gnomon::client {

struct SwitchingOptions {
  double position = 1.0;  // for each metre, summed over the three axes
  double up = 4.0;        // for each unit of the up vector's, the same
  double target = 4.0;    // for each unit of the forward vector's
  double latency = 0.05;  // for each second, subtracted
  double high = 0.12;
  double mid = 0.08;
  double low = 0.04;
  uint32_t dwell = 30;  // frames to remain in sequential
};

class Switching : public Ahead {
 public:
  explicit Switching(const SwitchingOptions& options) : options_(options) {}
  size_t choose(const AheadChoice& choice) override;
  bool sequential() const { return sequential_; }

 private:
  double value_of(const AheadChoice& choice) const;
  void decide(double value);

  SwitchingOptions options_;
  bool sequential_ = false;
  uint32_t remain_ = 0;  // frames before the next decision
};

}  // namespace gnomon::client
