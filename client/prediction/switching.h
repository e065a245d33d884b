// The dissertation's automatic switching (3.5): the changes of the camera's position, up vector and target and the
// latency are summed with weights, and the sum is compared with three thresholds.
//
//   by default not sequential: shows the newest camera, predicted
//   above `high`: sequential for `dwell` frames: shows only what has masks (in this framework: the least x)
//   then: above `mid` it stays so for `dwell` frames more; between `low` and `mid` for one more; below `low` it ends
//
// A high latency is a reason not to be sequential, so it is subtracted. The dissertation gives no figures; these did
// best in tests/eval.
#pragma once

#include "client/prediction/prediction_policy.h"

namespace gnomon::client {

struct SwitchingOptions {
  double position = 1.0;  // for each metre, summed over the three axes
  double up = 4.0;        // for each unit by which the up vector changed, likewise
  double target = 4.0;    // for each unit by which the forward vector changed
  double latency = 0.05;  // for each second, subtracted
  double high = 0.12;
  double mid = 0.08;
  double low = 0.04;
  uint32_t dwell = 30;  // frames to remain in sequential
};

class Switching : public PredictionPolicy {
 public:
  explicit Switching(const SwitchingOptions& options) : options_(options) {}
  size_t choose(const PredictionChoice& choice) override;
  bool sequential() const { return sequential_; }

 private:
  double value_of(const PredictionChoice& choice) const;
  void decide(double value);

  SwitchingOptions options_;
  bool sequential_ = false;
  uint32_t remain_ = 0;  // frames before the next decision
};

}  // namespace gnomon::client
