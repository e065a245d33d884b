// What a client shows next: which camera, with whose masks. Pure: no clock, no network.
//
//   asked(camera n) ... answered(n - p) ... next() -> {camera n - p + x, masks of n - p}
#pragma once

#include <deque>
#include <memory>
#include <optional>

#include "client/prediction/ahead.h"
#include "client/prediction/mode.h"

namespace gnomon::client {

struct Shown {
  AskedCamera camera;
  uint32_t newest = 0;       // index of the camera of this moment
  AskedCamera seen;          // whose masks it is shown with
  bool reprojected = false;  // they are predicted for it; false: used as they are
  size_t ahead() const { return camera.index - seen.index; }
};

class ShowOrder {
 public:
  // `ahead`: for predicted and automatic.
  ShowOrder(Mode mode, std::unique_ptr<Ahead> ahead);

  void asked(const protocol::CameraView& camera, TimePoint now);  // indices count from 0
  // Masks of that camera have come. False: newer ones came before, or it is unknown.
  bool answered(uint32_t index, TimePoint now);

  // Nothing: no masks yet, or the same as last time.
  std::optional<Shown> next(TimePoint now);

  uint32_t asked_count() const { return count_; }
  Ahead& ahead() { return *ahead_; }

 private:
  size_t choose(TimePoint now);

  Mode mode_;
  std::unique_ptr<Ahead> ahead_;
  uint32_t count_ = 0;
  std::deque<AskedCamera> cameras_;  // from the seen one on, once there is one
  bool any_seen_ = false;
  Nanoseconds latency_{};
  std::optional<std::pair<uint32_t, uint32_t>> last_;  // shown: camera, seen
};

}  // namespace gnomon::client
