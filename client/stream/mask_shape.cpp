#include "client/stream/mask_shape.h"

#include <algorithm>

namespace gnomon::client {
namespace {

std::vector<bool> which_are_areas(const std::vector<protocol::AreaInfo>& areas, size_t lights) {
  std::vector<bool> is_area(lights);
  for (size_t i = 0; i < std::min(lights, areas.size()); ++i) is_area[i] = areas[i].is_area();
  return is_area;
}

}  // namespace

MaskShape::MaskShape(const protocol::Welcome& granted)
    : features_(granted.features),
      granted_width_(granted.width),
      granted_height_(granted.height),
      granted_samples_(granted.samples),
      width_(granted.width),
      height_(granted.height),
      samples_(granted.samples),
      is_area_(which_are_areas(granted.areas, granted.scene.lights.size())) {}

// A server that makes more of what it granted is not believed.
void MaskShape::take(const protocol::Degraded& degraded) {
  if (degraded.width > 0 && degraded.width <= granted_width_) width_ = degraded.width;
  if (degraded.height > 0 && degraded.height <= granted_height_) height_ = degraded.height;
  if (degraded.samples > 0 && degraded.samples <= granted_samples_) samples_ = degraded.samples;
}

void MaskShape::take(const protocol::SceneChanged& changed) {
  is_area_ = which_are_areas(changed.areas, changed.scene.lights.size());
  samples_ = granted_samples_ = std::max<uint32_t>(changed.samples, 1);
}

void MaskShape::take(const protocol::LightsChanged& changed) { is_area_.resize(changed.lights.size()); }

bool MaskShape::is_of(const protocol::SliceHeader& header) const {
  const bool says_size = (header.flags & protocol::kSliceHasSize) != 0;
  const bool says_samples = (header.flags & protocol::kSliceHasSamples) != 0;
  const bool size = !has(protocol::kFeatureSizes) || ((says_size ? header.width : granted_width_) == width_ &&
                                                      (says_size ? header.height : granted_height_) == height_);
  return size && (!has(protocol::kFeatureSoft) || (says_samples ? header.samples : granted_samples_) == samples_);
}

bool MaskShape::tells_apart(const MaskShape& other) const {
  const bool same_lights = is_area_ == other.is_area_ && granted_samples_ == other.granted_samples_;
  const bool same_planes = planes() == other.planes();
  return has(protocol::kFeatureSizes) && (same_planes || (same_lights && has(protocol::kFeatureSoft)));
}

}  // namespace gnomon::client
