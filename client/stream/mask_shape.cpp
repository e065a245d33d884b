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
      width_(granted.width),
      height_(granted.height),
      granted_samples_(sample_counts_of(granted.samples)),
      samples_(granted_samples_),
      is_area_(which_are_areas(granted.areas, granted.scene.lights.size())) {}

// A server that makes more of what it granted is not believed.
void MaskShape::take(const protocol::Degraded& degraded) {
  if (degraded.width > 0 && degraded.width <= granted_width_) width_ = degraded.width;
  if (degraded.height > 0 && degraded.height <= granted_height_) height_ = degraded.height;
  const SampleCounts told = sample_counts_of(degraded.samples);
  if (degraded.samples > 0 && fewest(told, granted_samples_) == told) samples_ = told;
}

void MaskShape::take(const protocol::SceneChanged& changed) {
  is_area_ = which_are_areas(changed.areas, changed.scene.lights.size());
  samples_ = granted_samples_ = sample_counts_of(std::max<uint8_t>(changed.samples, 1));
}

void MaskShape::take(const protocol::LightsChanged& changed) { is_area_.resize(changed.lights.size()); }

bool MaskShape::is_of(const protocol::SliceHeader& header) const {
  const bool says_size = (header.flags & protocol::kSliceHasSize) != 0;
  const bool says_samples = (header.flags & protocol::kSliceHasSamples) != 0;
  const bool size = !has(protocol::kFeatureSizes) || ((says_size ? header.width : granted_width_) == width_ &&
                                                      (says_size ? header.height : granted_height_) == height_);
  const SampleCounts samples = says_samples ? sample_counts_of(header.samples) : granted_samples_;
  return size && (!has(protocol::kFeatureSoft) || samples == samples_);
}

bool MaskShape::tells_apart(const MaskShape& other) const {
  const bool same_lights = is_area_ == other.is_area_ && granted_samples_ == other.granted_samples_;
  const bool same_planes = planes() == other.planes();
  return has(protocol::kFeatureSizes) && (same_planes || (same_lights && has(protocol::kFeatureSoft)));
}

}  // namespace gnomon::client
