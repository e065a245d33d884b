#include "client/prediction/show_order.h"

#include <algorithm>
#include <utility>

namespace gnomon::client {
namespace {

// A server may never answer, or stop to: beyond so many cameras the oldest is forgotten, and its masks with it.
constexpr size_t kMostCameras = 4096;

}  // namespace

ShowOrder::ShowOrder(Mode mode, std::unique_ptr<PredictionPolicy> ahead) : mode_(mode), ahead_(std::move(ahead)) {
  if (waits_for_masks(mode) || !ahead_) ahead_ = std::make_unique<FixedPrediction>(0);
}

void ShowOrder::asked(const protocol::CameraView& camera, TimePoint now) {
  cameras_.push_back({count_++, camera, now});
  if (cameras_.size() <= kMostCameras) return;
  cameras_.pop_front();
  any_seen_ = false;
}

bool ShowOrder::answered(uint32_t index, TimePoint now) {
  if (cameras_.empty() || index < cameras_.front().index || index >= count_) return false;
  if (any_seen_ && index == cameras_.front().index) return false;
  cameras_.erase(cameras_.begin(), cameras_.begin() + (index - cameras_.front().index));
  any_seen_ = true;
  latency_ = now - cameras_.front().asked;
  return true;
}

size_t ShowOrder::choose(TimePoint now) {
  const uint32_t seen = cameras_.front().index;
  const size_t least = last_ && last_->first > seen ? last_->first - seen : 0;
  if (mode_ == Mode::non_sequential) return cameras_.size() - 1;
  return ahead_->choose({cameras_, least, latency_, now});
}

std::optional<Shown> ShowOrder::next(TimePoint now) {
  if (!any_seen_) return std::nullopt;
  const RequestedCamera& camera = cameras_[choose(now)];
  const RequestedCamera& seen = cameras_.front();
  const std::pair shown(camera.index, seen.index);
  if (last_ == shown) return std::nullopt;
  last_ = shown;
  const bool reprojected = mode_ != Mode::non_sequential && camera.index != seen.index;
  return Shown{.camera = camera, .newest = count_ - 1, .seen = seen, .reprojected = reprojected};
}

}  // namespace gnomon::client
