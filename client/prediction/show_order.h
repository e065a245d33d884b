// Decides which camera a client shows next, and with whose masks. No clock, no network.
//
//   asked(camera n) ... answered(n - p) ... next() -> {camera n - p + x, masks of n - p}
#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "client/prediction/mode.h"
#include "client/prediction/prediction_policy.h"

namespace gnomon::client {

struct Shown {
  RequestedCamera camera;
  uint32_t newest = 0;       // index of the newest camera
  RequestedCamera seen;      // whose masks it is shown with
  bool reprojected = false;  // the masks are predicted for the camera; false: used as they are
  size_t ahead() const { return camera.index - seen.index; }
};

class ShowOrder {
 public:
  // `ahead` is for the modes predicted and automatic; null: x = 0.
  ShowOrder(Mode mode, std::unique_ptr<PredictionPolicy> ahead);

  void asked(const protocol::CameraView& camera, TimePoint now);  // indices count from 0
  // The masks of camera `index` have arrived. False if they, or newer ones, had arrived before, or it is unknown.
  bool answered(uint32_t index, TimePoint now);

  // nullopt if no masks have arrived yet, or there is nothing else to show than last time.
  std::optional<Shown> next(TimePoint now);

  uint32_t asked_count() const { return count_; }
  PredictionPolicy& ahead() { return *ahead_; }

 private:
  size_t choose(TimePoint now);

  Mode mode_;
  std::unique_ptr<PredictionPolicy> ahead_;
  uint32_t count_ = 0;
  std::deque<RequestedCamera> cameras_;  // from the newest with masks on, once there is one
  bool any_seen_ = false;
  Nanoseconds latency_{};
  std::optional<std::pair<uint32_t, uint32_t>> last_;  // indices shown last: camera, seen
};

}  // namespace gnomon::client
