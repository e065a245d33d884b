// The lights of a resident scene that have an extent, and the points of them that soft frames trace.
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "gpu/renderer.h"
#include "gpu/scene/traced_lights.h"
#include "scenes/light_samples.h"

namespace gnomon::gpu {

// Which lights have an extent stays as the scene was loaded, so that a frame's planes do; how large it is and where the
// light stands may change.
class AreaLights {
 public:
  AreaLights() = default;
  explicit AreaLights(const std::vector<scenes::Light>& loaded);

  bool any() const { return set_.any(); }
  bool is_area(size_t light) const { return set_[light]; }
  const LightSet& set() const { return set_; }

  // In a frame that asks for `wanted`: one per light if there are none, so that it is a frame as any other.
  SampleCounts samples(SampleCounts wanted) const { return any() ? wanted : SampleCounts{1, wanted.occlusion}; }
  // Of a frame's mask with these samples, as LightPlanes::total.
  uint32_t plane_count(SampleCounts samples) const {
    return lights_ + static_cast<uint32_t>(set_.count()) * (planes_of(samples.per_light) - 1) +
           planes_of(samples.occlusion);
  }
  // Points of all area lights, at most.
  uint32_t most_points() const {
    return static_cast<uint32_t>(set_.count()) * scenes::kSamplePatterns * kMostSamples;
  }

  // What was built for the extents of the area lights, in their order; no `traced` until then.
  const TracedLights& built() const { return built_; }
  void give(TracedLights built) { built_ = std::move(built); }

  // As scenes::sample_offsets of an area light that has this area now; kept until the light has another one. The render
  // loop's thread. Valid until the next call.
  const std::vector<glm::vec3>& offsets(size_t light, const scenes::LightArea& area, uint32_t samples) const;

 private:
  struct Kept {
    scenes::LightArea area;
    std::vector<glm::vec3> offsets;  // if empty, none yet
  };

  uint32_t lights_ = 0;
  LightSet set_;
  TracedLights built_;
  mutable std::vector<std::array<Kept, 2>> kept_;  // light by light: for 4 samples, for 16
};

// The light with its extent, as a build for areas takes it. `traced`: the light as tracers use it.
exact::TracedLight with_extent(exact::TracedLight traced, const scenes::LightArea& area);

}  // namespace gnomon::gpu
